"""Scripts that are asked about contacts (``sysCall_contactCallback``), and told of each step (``sysCall_dynCallback``).

Two shapes that come near each other are asked about once in a pass, of all scripts that have the call-back in their
order: the first that does not leave the pair to others (``ignoreContact``) says whether they collide
(``collisionResponse``). Friction and the like stay the scene's; geoms that are no object are not asked about. Both
call-backs also have the names of CoppeliaSim 4.5.

Neither may edit the scene, for the steps of a pass work on one model; while contacts are asked about, within a step,
the state cannot even be copied: no pictures, and other clients wait.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.scripting.lives import Lives
from simx_server.world.contact_filter import ask_about_contacts, ask_no_more

if TYPE_CHECKING:
    from simx_server.scripting.interpreter import Plain
    from simx_server.scripting.script import Script
    from simx_server.world.simulation import Simulation

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
        """By pair of shapes what was answered in this pass."""
        self._is_asked = False

    def forget_answers(self) -> None:
        """Another simulation step begins: scripts are asked again."""
        self._known.clear()

    def watch(self, scripts: list[Script]) -> None:
        """Scripts have begun or ended."""
        self._contact = _having(scripts, CONTACT)
        self._step = _having(scripts, STEP)
        wants = bool(self._contact) and self._sim.is_running
        if wants and not self._is_asked:
            ask_about_contacts(self._sim, self._may_touch)
        elif self._is_asked and not wants:
            ask_no_more(self._sim)
        self._is_asked = self._sim.sleepers.contacts_are_asked_about = wants
        self._sim.joints.accompany(self._tell if self._step else None)

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
        """Before and after physics step `index` (from 0) of the `count` of a pass."""
        self._sim.changed()  # what a script reads now is of this step
        known = {
            "passCnt": index + 1,
            "totalPasses": count,
            "dynStepSize": float(self._sim.model.opt.timestep),
            "afterStep": is_after,
        }
        for script, function in self._step:
            with self._sim.physics_calls.calling(function):
                self._lives.call(script, function, known)


def _having(scripts: list[Script], functions: tuple[str, ...]) -> list[tuple[Script, str]]:
    """Those that have one of the functions, with its name."""
    return [(one, name) for one in scripts for name in functions if one.has(name)]


def _table(results: list[Plain] | None) -> dict[Any, Any] | None:
    return results[0] if results and isinstance(results[0], dict) else None
