"""Whether two geoms may touch, asked while MuJoCo collides: by simulations that have somebody who decides.

MuJoCo has one such hook for the whole process (`mjcb_contactfilter`). It is set only while a simulation wants to be
asked; one process may hold several, so the hook looks whose state it is about, and hands on to what was set before.

It is safe and cheap enough, measured with MuJoCo 4.0 on one core: the hook gets the very MjData that is stepped, on the
stepping thread with the interpreter's lock, also while another thread steps; it may take itself away while it runs; it
is called for pairs that the broad phase leaves, after contype and conaffinity. A Python function costs 0.3
microseconds a call: 8 in a step of 55 with 25 boxes on a plane. An exception would unwind through MuJoCo's C code and
leave its stack as it is, so none leaves the hook.
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
"""The hook is read, changed and set in one go."""


class _Hook:
    """What is set in MuJoCo. It is found there again, so nothing else of the process keeps state."""

    def __init__(self, before: Callable[..., int] | None) -> None:
        self.before = before
        self.asked: dict[LiveScene, MayTouch] = {}

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> int:
        """1 drops the pair."""
        for sim, may_touch in tuple(self.asked.items()):
            if sim.data is data:
                try:
                    return int(not may_touch(first, second))
                except Exception:
                    logger.exception("a contact could not be asked about; it counts")
                    return 0
        return self.before(model, data, first, second) if self.before is not None else 0


def ask_about_contacts(sim: LiveScene, may_touch: MayTouch) -> None:
    """From now on this decides about the contacts of a simulation's own state; nothing else is asked."""
    with _SETTING:
        present = mujoco.get_mjcb_contactfilter()
        hook = present if isinstance(present, _Hook) else _Hook(present)
        hook.asked[sim] = may_touch
        if hook is not present:
            mujoco.set_mjcb_contactfilter(hook)


def ask_no_more(sim: LiveScene) -> None:
    """Undo `ask_about_contacts`; the last simulation to do so brings back what was set in MuJoCo before."""
    with _SETTING:
        hook = mujoco.get_mjcb_contactfilter()
        if not isinstance(hook, _Hook):
            return
        hook.asked.pop(sim, None)
        if not hook.asked:
            mujoco.set_mjcb_contactfilter(hook.before)
