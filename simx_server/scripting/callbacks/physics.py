"""Call-backs for contacts (``sysCall_contactCallback``) and for each physics step (``sysCall_dynCallback``).

When two shapes come near each other, all scripts with the call-back are called once in a simulation step, in their
order: the first that does not leave the pair to others (``ignoreContact``) decides whether they collide
(``collisionResponse``). Friction and similar properties stay those of the scene; geoms that do not belong to an
object are left out. Both call-backs also have the names of CoppeliaSim 4.5.

Neither may edit the scene, because all physics steps of a simulation step use the same model. During the contact
call-back, within a physics step, the state cannot even be copied: images are not available, and other clients wait.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from simx_server.scripting.lives import Lives
from simx_server.simulation.contact_filter import ask_about_contacts, ask_no_more

if TYPE_CHECKING:
    from simx_server.scripting.interpreter import Plain
    from simx_server.scripting.script import Script
    from simx_server.simulation.simulation import Simulation

CONTACT = ("sysCall_contactCallback", "sysCall_contact")
STEP = ("sysCall_dynCallback", "sysCall_dyn")

_MUJOCO = 4
"""sim.physics_mujoco."""


class PhysicsCallBacks:
    """The scripts that have such call-backs."""

    def __init__(self, sim: Simulation, lives: Lives) -> None:
        self._sim = sim
        self._lives = lives
        self._contact: list[tuple[Script, str]] = []
        self._step: list[tuple[Script, str]] = []
        self._known: dict[tuple[int, int], bool] = {}
        """Answers of this simulation step by pair of shapes."""
        self._is_asked = False

    def forget_answers(self) -> None:
        """Delete the answers at the start of another simulation step, so that scripts are called again."""
        self._known.clear()

    def watch(self, scripts: Sequence[Script]) -> None:
        """Update the lists of call-backs after scripts have started or ended."""
        self._contact = _having(scripts, CONTACT)
        self._step = _having(scripts, STEP)
        wants = bool(self._contact) and self._sim.is_running
        if wants and not self._is_asked:
            ask_about_contacts(self._sim, self._may_touch)
        elif self._is_asked and not wants:
            ask_no_more(self._sim)
        self._is_asked = wants
        self._sim.sleepers.note_contact_callback(wants)
        self._sim.joints.controllers.accompany(self._tell if self._step else None)

    def _may_touch(self, first: int, second: int) -> bool:
        scene, model = self._sim.scene, self._sim.model
        one, other = scene.owner_of_geom(first, model), scene.owner_of_geom(second, model)
        if -1 in (one, other):
            return True
        pair = (one, other) if one < other else (other, one)
        if pair not in self._known:
            self._known[pair] = self._ask(*pair)
        return self._known[pair]

    def _ask(self, one: int, other: int) -> bool:
        known = {"handle1": one, "handle2": other, "engine": _MUJOCO}
        for script, function in self._contact:
            with self._sim.physics_calls.calling(function, in_step=True):
                answer = _table(self._lives.call(script, function, known))
            if answer is not None and not answer.get("ignoreContact"):
                return bool(answer.get("collisionResponse", True))
        return True

    def _tell(self, index: int, count: int, is_after: bool) -> None:
        """Call the scripts before or after physics step `index` (from 0) of the `count` of a simulation step."""
        self._sim.changed()  # scripts now read values of this physics step
        known = {
            "passCnt": index + 1,
            "totalPasses": count,
            "dynStepSize": float(self._sim.model.opt.timestep),
            "afterStep": is_after,
        }
        for script, function in self._step:
            with self._sim.physics_calls.calling(function):
                self._lives.call(script, function, known)


def _having(scripts: Sequence[Script], functions: tuple[str, ...]) -> list[tuple[Script, str]]:
    """Return the scripts that have one of the functions, with its name."""
    return [(one, name) for one in scripts for name in functions if one.has(name)]


def _table(results: list[Plain] | None) -> dict[Any, Any] | None:
    return results[0] if results and isinstance(results[0], dict) else None
