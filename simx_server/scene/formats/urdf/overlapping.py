"""Links that overlap in the pose of the file do not collide with each other.

MuJoCo's colliding meshes are convex hulls, which are larger than the links; a file's own shapes may overlap too. Gazebo
ignores collisions within a robot, and MoveIt's assistant leaves out those of the default pose.
"""

from __future__ import annotations

import logging

import mujoco

from .names import MOST_NAMED

logger = logging.getLogger(__name__)

_DEPTH = 1e-3
"""Metres: touching links go on colliding."""


def part_overlapping(spec: mujoco.MjSpec, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Exclude the collisions of pairs of bodies that overlap.

    Args:
        spec: the robot, without a floor.
        model: the compiled spec.
        data: its state in the pose of the file, with contacts.
    """
    pairs: dict[tuple[int, int], float] = {}
    for contact in data.contact:
        if contact.dist < -_DEPTH:
            first, second = sorted(int(model.geom_bodyid[geom]) for geom in contact.geom)
            pairs[first, second] = min(pairs.get((first, second), 0.0), float(contact.dist))
    for first, second in pairs:
        spec.add_exclude(bodyname1=model.body(first).name, bodyname2=model.body(second).name)
    if pairs:
        deepest = sorted(pairs, key=lambda pair: pairs[pair])
        named = ", ".join(
            f"'{model.body(first).name}' and '{model.body(second).name}'"
            for first, second in deepest[:MOST_NAMED]
        )
        more = f" and {len(pairs) - MOST_NAMED} more pairs" if len(pairs) > MOST_NAMED else ""
        logger.info("links that overlap in the pose of the file do not collide: %s%s", named, more)
