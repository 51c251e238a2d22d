"""Convert a file of V-REP or CoppeliaSim to an MjSpec with annotations."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from typing import Any

import mujoco

from simx_server.scene.poses.poses import Pose

from .conversion.context import Conversion
from .conversion.facts.custom_data import add_custom_data
from .conversion.facts.graphs import add_graph
from .conversion.facts.ik_groups import add_ik_groups
from .conversion.facts.motion_plannings import add_motion_plannings
from .conversion.facts.path_plannings import add_path_plannings
from .conversion.facts.registered import add_registered
from .conversion.facts.scripts import add_scripts
from .conversion.facts.settings import add_settings
from .conversion.facts.user_parameters import add_user_parameters
from .conversion.geometry.masks import add_exclusions
from .conversion.geometry.points import add_points
from .conversion.inertia import set_inertia
from .conversion.joints import add_joint
from .conversion.link_contacts import ease_link_contacts
from .conversion.loops import add_links, add_loops, turn_bare_joints
from .conversion.masses import give_masses
from .conversion.old_uis import add_uis
from .conversion.paths import add_followers, add_path
from .conversion.physics import set_physics
from .conversion.resting import let_rest
from .conversion.sensing.cameras import add_camera
from .conversion.sensing.force import add_force_sensor
from .conversion.sensing.inert import report_inert
from .conversion.sensing.lights import add_light, set_surroundings
from .conversion.sensing.proximity import add_proximity
from .conversion.sensing.vision import add_vision
from .conversion.shapes import add_geoms
from .conversion.structure import Leaf, Structure
from .conversion.unique_names import UniqueNames
from .objects import (
    Camera,
    ForceSensor,
    Graph,
    Light,
    Path,
    PointCloud,
    ProximitySensor,
    Shape,
    VisionSensor,
    VrepFile,
    VrepObject,
)
from .report import Report

LEAVES: Mapping[type[VrepObject], Leaf] = {
    Camera: add_camera,
    Light: add_light,
    ProximitySensor: add_proximity,
    VisionSensor: add_vision,
    ForceSensor: add_force_sensor,
    Path: add_path,
    Graph: add_graph,
    PointCloud: add_points,
}
"""Converters of objects that are not bodies, by class; all others become sites."""


def convert(file: VrepFile) -> tuple[mujoco.MjSpec, Report]:
    """Return a decoded file as a spec, complete with annotations, meshes, textures and the texts of the scripts.

    Its objects have the names that `names_of` returns.

    Args:
        file: its objects form a tree, as `read_file` has checked.

    Returns:
        The spec; and what it approximates or lacks.
    """
    file = turn_bare_joints(file)
    report = Report(file.name, file.version, faults=file.notes, skipped=file.skipped)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    conversion = Conversion(file, spec, report, names_of(file))
    structure = Structure(conversion, _add_shape, add_joint, LEAVES)
    structure.build()
    add_loops(conversion, structure)
    add_links(conversion)
    add_followers(conversion)
    add_uis(conversion)
    add_exclusions(conversion)
    add_scripts(conversion)
    add_user_parameters(conversion)
    add_custom_data(conversion)
    add_registered(conversion)
    add_ik_groups(conversion)
    add_path_plannings(conversion)
    add_motion_plannings(conversion)
    add_settings(conversion)
    give_masses(spec)
    let_rest(conversion)
    ease_link_contacts(spec)
    set_physics(conversion)
    set_surroundings(conversion)
    report_inert(conversion)
    report.objects = Counter(_kind_of(item) for item in file.objects.values())
    conversion.write_notes()
    return spec, report


def _add_shape(conversion: Conversion, shape: Shape, body: Any, at: Pose) -> None:
    """Fill the body of a shape. Its mass counts only while it is dynamic."""
    add_geoms(conversion, shape, body, at)
    set_inertia(conversion, shape, body)


_NOT_IN_NAMES = re.compile(r"[\s,;/%]+")
"""Characters that names of objects cannot have here: annotations separate by spaces, commas and semicolons, paths by
slashes.
"""


def names_of(file: VrepFile) -> dict[int, str]:
    """Return a unique name for each object by its handle, its own one wherever possible."""
    unique = UniqueNames("{}_{}", taken=("world", "main", "all"))
    return {
        handle: unique.take(
            _NOT_IN_NAMES.sub("_", item.name or item.alias or "object").lstrip("~") or "object"
        )
        for handle, item in file.objects.items()
    }


def _kind_of(item: VrepObject) -> str:
    kind = getattr(item, "kind", None)
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(item).__name__).lower()
    return str(kind) if kind else words
