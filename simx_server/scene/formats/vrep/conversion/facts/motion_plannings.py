"""Motion planning tasks of a V-REP file."""

from __future__ import annotations

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import MotionPlanning


def add_motion_plannings(conversion: Conversion) -> None:
    """Annotate the motion planning tasks; called when all objects and groups of inverse kinematics were added."""
    groups = {group.id: group.name for group in conversion.file.ik_groups}
    for planning in conversion.file.motion_plannings:
        _add(conversion, planning, groups.get(planning.group))


def _add(conversion: Conversion, planning: MotionPlanning, group: str | None) -> None:
    names = conversion.names
    is_whole = planning.joints and all(joint in names for joint in planning.joints)
    if not is_whole or not planning.name or ("ik", group) not in conversion.notes:
        conversion.report.leave_out(
            "motion planning tasks without joints or a group of inverse kinematics", planning.name
        )
        return
    first, second = planning.own
    conversion.annotate(
        "motion_planning",
        planning.name,
        joints=",".join(names[joint] for joint in planning.joints),
        ik=group,
        robot=None if planning.robot == -1 else conversion.entity(planning.robot),
        obstacles=None if planning.robot == -1 else conversion.entity(planning.obstacles),
        own=None if first == -1 else conversion.entity(first),
        own_others=None if first == -1 else conversion.entity(second),
        clearance=max(planning.clearances[0], 0.0) or None,
        own_clearance=max(planning.clearances[1], 0.0) or None,
        tip_weights=_text(planning.tip_weights),
        weights=_text(planning.joint_weights) or None,
    )


def _text(numbers: tuple[float, ...]) -> str:
    return ",".join(f"{max(number, 0.0):.9g}" for number in numbers)
