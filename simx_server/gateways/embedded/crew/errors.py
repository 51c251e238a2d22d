"""Why compiled code could not make physics."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from simx_server.joints.native.loading import crew_form
from simx_server.joints.stepping.motors import no_room

if TYPE_CHECKING:
    from simx_server.joints.native._crew import Course


def error_of(course: Course, data: mujoco.MjData) -> BaseException:
    """Return why the physics of a course, with this data, could not be made."""
    compiled = crew_form().module
    assert compiled is not None
    if course.outcome == compiled.NO_ROOM:
        return no_room(data)
    return mujoco.FatalError(course.problem) if course.outcome == compiled.FAILED else course.error
