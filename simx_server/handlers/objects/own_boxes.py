"""The box of a single object in its own frame, by its kind: V-REP gives one to every object.

An object without a form has the box of the mark that V-REP draws, and a sensor that of what it senses too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.editing.marks import joint_sizes, mark_size, sensor_body
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.sensors.instant import Instant
from simx_server.sensors.vision.vision_settings import VisionSettings

from .geom_boxes import box_of_geoms, half_sides_of_site

if TYPE_CHECKING:
    from simx_server.world.world import World

Array = NDArray[np.float64]

_CUBE = ((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
_CAMERA = ((-0.5, -0.5, -2.6), (0.5, 2.2, 1.0))
_SPOT = ((-0.8, -0.8, -1.5), (0.8, 0.8, 0.5))
"""Boxes of V-REP's marks of size 1."""


def own_box(world: World, instant: Instant, item: SceneObject, *, with_volumes: bool) -> Array | None:
    """Return (2, 3) least and greatest x, y, z of an object in its own frame, metres; None where it is not known.

    Args:
        world: the world.
        instant: its present state.
        item: the object.
        with_volumes: whether the box of a sensor includes what it senses.
    """
    model = instant.model
    match item.kind:
        case ObjectKind.SHAPE | ObjectKind.OCTREE | ObjectKind.POINT_CLOUD:
            return _of_form(instant, item)
        case ObjectKind.DUMMY if item.element == "site":
            return _about_origin(*half_sides_of_site(model, item.id))
        case ObjectKind.JOINT:
            return _of_joint(world, item)
        case ObjectKind.PROXIMITY_SENSOR if with_volumes:
            return _around(_scaled(_CUBE, mark_size(model, item)), world.proximity.box(item.handle))
        case ObjectKind.VISION_SENSOR:
            width, height, depth = sensor_body(item)
            body = np.array([[-width / 2, -height / 2, -depth], [width / 2, height / 2, 0.0]])
            return _around(body, _of_view(world.vision.settings(item.handle))) if with_volumes else body
        case ObjectKind.CAMERA:
            return _scaled(_CAMERA, mark_size(model, item))
        case ObjectKind.LIGHT:
            return _scaled(_SPOT if _is_spot(model, item.id) else _CUBE, mark_size(model, item))
        case (
            ObjectKind.DUMMY
            | ObjectKind.PROXIMITY_SENSOR
            | ObjectKind.FORCE_SENSOR
            | ObjectKind.GRAPH
            | ObjectKind.PATH
        ):
            return _scaled(_CUBE, mark_size(model, item))
        case _:
            return None


def _of_form(instant: Instant, item: SceneObject) -> Array | None:
    known = instant.surroundings.form_boxes  # an edit of a form makes another model
    if item.handle not in known:
        geoms: list[int] = instant.geoms_of((item.handle,)).tolist()
        known[item.handle] = box_of_geoms(instant.model, item, geoms)
    return known[item.handle]


def _of_joint(world: World, item: SceneObject) -> Array:
    length, diameter = joint_sizes(item)
    if world.simulation.joints.joint_type(item.handle) == _SPHERICAL:
        return _about_origin(diameter, diameter, diameter)
    return _about_origin(diameter / 2, diameter / 2, length / 2)


_SPHERICAL = 12


def _of_view(settings: VisionSettings) -> Array:
    """Return the box around what a vision sensor sees between its clip planes, which look along z."""
    wide, high = settings.width, settings.height
    most = math.tan(settings.angle / 2) * settings.far if settings.is_perspective else settings.size / 2
    x, y = most * min(1.0, wide / high), most * min(1.0, high / wide)
    return np.array([[-x, -y, settings.near], [x, y, settings.far]])


def _is_spot(model: mujoco.MjModel, light: int) -> bool:
    """Return whether a light has a cone; those that shine everywhere are spots of more than half a sphere."""
    is_spot = int(model.light_type[light]) == int(mujoco.mjtLightType.mjLIGHT_SPOT)
    return is_spot and float(model.light_cutoff[light]) <= _WIDEST


_WIDEST = 90.0
"""Degrees."""


def _scaled(unit: tuple[tuple[float, ...], ...], size: float) -> Array:
    return np.array(unit) * size


def _about_origin(x: float, y: float, z: float) -> Array:
    return np.array([[-x, -y, -z], [x, y, z]])


def _around(one: Array, other: Array) -> Array:
    return np.stack([np.minimum(one[0], other[0]), np.maximum(one[1], other[1])])
