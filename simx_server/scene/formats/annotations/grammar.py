"""GRAMMAR, the whole list of kinds and keys of annotations, with the check of each value."""

from __future__ import annotations

from collections.abc import Callable

from simx_server.scene.formats.texts.graph_streams import check_curves, check_streams
from simx_server.scene.formats.texts.old_uis import UI_TEXT
from simx_server.scene.formats.texts.path_points import check_points
from simx_server.scene.formats.texts.render_modes import MODE_OF
from simx_server.scene.formats.texts.scripts import SCRIPT_TYPES, TEXT_KINDS
from simx_server.scene.formats.texts.values import block, each, steps, two_numbers

from .annotation import Value
from .checks import (
    DETECTABLE_KINDS,
    angle,
    bits,
    colour,
    count,
    detectable,
    filters,
    four_weights,
    link_type,
    looks,
    not_negative,
    number,
    one_number,
    one_of,
    place,
    positive,
    quaternion,
    share,
    six_numbers,
    some_of,
    switch,
    three_numbers,
    twelve_bytes,
    weights,
)
from .ros2_keys import ROS2_KEYS

ENGINES = ("bullet", "ode", "vortex", "newton", "mujoco", "physx")
"""Physics engines by V-REP's numbers, from 0."""

GRAMMAR: dict[str, dict[str, Callable[[str], Value]]] = {
    "object": {
        "type": one_of("graph", "path", "mill", "mirror", "octree", "point_cloud", "script"),
        "alias": str,
        "parent": str,
        "order": place,
        "sibling": place,
        "layers": bits,
        "flags": bits,
        "size_factor": positive,
        "size_values": three_numbers,
        "mark": positive,
        "extension": str,
    },
    "joint": {
        "mode": one_of("force", "passive", "ik", "dependent", "motion", "ik_dependent"),
        "motor": switch,
        "control": one_of("position", "velocity", "spring", "force", "script"),
        "P": not_negative,
        "I": not_negative,
        "D": not_negative,
        "K": number,
        "C": number,
        "upper_velocity": positive,
        "upper_acceleration": positive,
        "upper_jerk": positive,
        "max_force": number,
        "lock": switch,
        "hybrid": switch,
        "spring": switch,
        "alignment": quaternion,
        "rewind": switch,
        "cyclic": switch,
        "switches": switch,
        "fixed": switch,
        "rigid": switch,
        "turn": quaternion,
        "target_position": number,
        "target_velocity": number,
        "parent": str,
        "offset": number,
        "master": str,
        "multiplication": number,
        "ik_weight": not_negative,
        "length": positive,
        "diameter": positive,
    },
    "vision": {
        "near": positive,
        "far": positive,
        "angle_deg": positive,
        "explicit": switch,
        "external": switch,
        "size": positive,
        "body": three_numbers,
        "render": one_of(*MODE_OF),
        "detect_above": share,
        "detect_below": share,
        "background": colour,
        "rgb": switch,
        "depth": switch,
        "statistics": switch,
        "entity": str,
        "filters": filters,
        "single_pixel": switch,
    },
    "camera": {"view": switch, "whole": switch},
    "dummy": {
        "linked": str,
        "link": link_type,
        "detectable": detectable,
        "collidable": switch,
        "measurable": switch,
        "color": twelve_bytes,
    },
    "proximity": {
        "type": one_of("ray", "cone", "cylinder", "pyramid", "disc", "random_rays"),
        "offset": number,
        "range": positive,
        "explicit": switch,
        "angle_deg": angle,
        "radius": not_negative,
        "radius_far": not_negative,
        "size_x": positive,
        "size_y": positive,
        "size_x_far": positive,
        "size_y_far": positive,
        "height": positive,
        "inside_gap": share,
        "rays": count,
        "rays_needed": count,
        "faces": one_of("both", "front", "back", "none"),
        "max_normal_deg": angle,
        "min_distance": not_negative,
        "entity": str,
        "detects": one_of(*DETECTABLE_KINDS),
        "carrier": switch,
    },
    "force": {
        "max_force": positive,
        "max_torque": positive,
        "violations": count,
        "overload": one_of("break", "trigger"),
        "samples": count,
        "filter": one_of("average", "median"),
    },
    "path": {
        "points": check_points,
        "closed": switch,
        "length": one_of(
            "distance", "angle", "larger", "sum", "root", "distance_or_angle", "angle_or_distance"
        ),
        "angle_to_length": not_negative,
        "virtual_to_length": not_negative,
        "orientation": one_of("points", "curve", "curve_x_up"),
        "flat": switch,
        "position": number,
        "velocity": number,
        "acceleration": not_negative,
        "explicit": switch,
    },
    "follow": {"offset": number},
    "cloud": {
        "voxel": positive,
        "most": place,
        "options": bits,
        "point_size": not_negative,
        "points": block,
        "colors": block,
        "tags": block,
        "color": colour,
    },
    "graph": {"explicit": switch, "streams": check_streams, "curves": check_curves},
    "shape": {
        "detectable": detectable,
        "collidable": switch,
        "measurable": switch,
        "renderable": switch,
        "static": switch,
        "mask": bits,
        "pair_mask": bits,
        "first_velocity": six_numbers,
        "looks": looks,
    },
    "collection": {
        "objects": str,
        "tree": str,
        "below": str,
        "chain": str,
        "all": switch,
        "without": str,
        "steps": steps,
        "overrides": switch,
    },
    "collision": {"entity1": str, "entity2": str, "explicit": switch},
    "distance": {"entity1": str, "entity2": str, "explicit": switch},
    "parameters": {},
    "kept": {},
    "data": {},
    "references": {},
    "script": {
        "file": str,
        "type": one_of(*SCRIPT_TYPES),
        "threaded": switch,
        "enabled": switch,
        "joint_bases": switch,
        "full_results": switch,
        "stops_at_errors": switch,
        "order": one_of("first", "normal", "last"),
        "traversal": one_of("reverse", "forward", "parent"),
    },
    **{kind: {} for kind in TEXT_KINDS},
    "planning": {
        "path": str,
        "start": str,
        "goal": str,
        "robot": str,
        "obstacles": str,
        "type": one_of("xy", "xyz", "xyg", "xyzabg"),
        "low": three_numbers,
        "high": three_numbers,
        "seconds": positive,
    },
    "motion_planning": {
        "joints": str,
        "ik": str,
        "robot": str,
        "obstacles": str,
        "own": str,
        "own_others": str,
        "clearance": not_negative,
        "own_clearance": not_negative,
        "weights": weights,
        "tip_weights": four_weights,
    },
    "ik": {
        "tip": str,
        "target": str,
        "base": str,
        "constraints": each(
            some_of("pose", "position", "orientation", "x", "y", "z", "alpha_beta", "gamma", "none")
        ),
        "active": each(switch),
        "precision": each(two_numbers),
        "weights": each(two_numbers),
        "method": one_of("pseudo_inverse", "damped", "transpose"),
        "damping": not_negative,
        "iterations": count,
        "handling": one_of("auto", "explicit"),
        "enabled": switch,
        "restore": some_of("position", "orientation"),
        "after": str,
        "axes": str,
        "ignores_steps": switch,
        "margins": two_numbers,
    },
    "model": {"base": switch, "properties": bits},
    "scene": {
        "engine": one_of(*ENGINES),
        "layers": bits,
        "background": colour,
        "dynamics": switch,
        "custom_step": switch,
        **dict.fromkeys(("collisions", "distances", "proximity", "vision", "paths"), switch),
    },
    "mount": {"on": str, "ahead": number},
    "copies": {"count": count, "x": number, "y": number, "z": number, "turn_deg": number},
    "ui": {"file": str},
    "ros2": ROS2_KEYS,
    UI_TEXT: {},
}

FREE: dict[str, Callable[[str], str]] = {
    "parameters": str,
    "kept": one_number,
    "data": block,
    "references": str,
}
"""Kinds that accept any key, for scripts to read, and the check of their values, which stay texts."""

PASSING = ("mount", "copies")
"""Kinds that change the scene when it is loaded, and have no meaning afterwards."""

UNTAGGED = "-"
"""Key of references to objects that have no tag."""

WORLD = "world"
"""In place of an object: none, or the scene itself."""

ENTITY_PREFIX = "collection:"
"""Before the name of a collection that must not be taken for an object of the same name."""

REGISTERED = ("collection", "collision", "distance", "ik", "planning", "motion_planning", "ui", UI_TEXT)
"""Kinds whose NAME is a separate name, not that of an object."""

BROUGHT = ("collection", "collision", "distance", "ik", "planning", "motion_planning", UI_TEXT)
"""Registered kinds that a model brings along."""
