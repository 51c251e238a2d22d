"""Properties of vision sensors and cameras: what they show, and the images of vision sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from simx_server.errors import CommandError
from simx_server.handlers import vision
from simx_server.parts.object_settings import DrawnSize
from simx_server.scripting.callbacks.images import wait_for
from simx_server.sim_api.properties.entry import Property, drawn_size, fixed, numbered
from simx_server.sim_api.properties.property_types import (
    BOOL,
    BUFFER,
    COLOR,
    FLOAT,
    FLOAT_ARRAY,
    INT,
    INT_ARRAY2,
    VECTOR3,
)

if TYPE_CHECKING:
    from simx_server.sensors.vision.vision_settings import VisionSettings
    from simx_server.world.world import World


def _settings(world: World, handle: int) -> VisionSettings:
    return world.vision.settings(handle)


def _clipping(world: World, handle: int) -> list[float]:
    settings = _settings(world, handle)
    return [settings.near, settings.far]


def _set_clipping(world: World, handle: int, values: list[float]) -> None:
    if len(values) != 2:
        raise CommandError(f"'clippingPlanes' is a table of near and far, not of {len(values)} numbers")
    world.vision.change(handle, near=values[0], far=values[1])


def _corner(place: int) -> Any:
    """Return the getter of the corner of the view at the near (0) or far (1) plane: half sizes, and depth."""

    def get(world: World, handle: int) -> list[float]:
        view = _settings(world, handle).view
        depth = view.clip[place]
        across, up = view.half
        return [across * depth, up * depth, depth] if view.is_perspective else [across, up, depth]

    return get


CAMERAS = (
    numbered("viewAngle", FLOAT, "visionfloatparam_perspective_angle"),
    numbered("viewSize", FLOAT, "visionfloatparam_ortho_size"),
    Property("clippingPlanes", FLOAT_ARRAY, _clipping, _set_clipping),
    numbered("perspective", BOOL, "visionintparam_perspective_operation", can_be_set=False),
    Property("frustumCornerNear", VECTOR3, _corner(0)),
    Property("frustumCornerFar", VECTOR3, _corner(1)),
    fixed("showFrustum", BOOL, False, "views are never drawn"),
)


def _switch(name: str, field: str, *, inverted: bool = False) -> Property:
    def get(world: World, handle: int) -> bool:
        return bool(getattr(_settings(world, handle), field)) != inverted

    return Property(
        name,
        BOOL,
        get,
        lambda world, handle, on: world.vision.change(handle, **{field: on != inverted}),
    )


def _background(world: World, handle: int) -> list[float]:
    own = _settings(world, handle).background
    return list(world.vision.background if own is None else own)


def _set_background(world: World, handle: int, color: list[float]) -> None:
    red, green, blue = (min(max(each, 0.0), 1.0) for each in color)
    world.vision.set_background(handle, (red, green, blue))


def _set_from_environment(world: World, handle: int, from_environment: bool) -> None:
    if from_environment:
        world.vision.set_background(handle, None)
    elif _settings(world, handle).background is None:
        _set_background(world, handle, _background(world, handle))


def _image(world: World, handle: int) -> bytes:
    return wait_for(world.simulation, world.vision.image(handle, as_grey=False, as_handled=True))[1]


def _depth(world: World, handle: int) -> bytes:
    return wait_for(world.simulation, world.vision.depth(handle, as_handled=True))[1]


def _reading(world: World, handle: int) -> tuple[bool, list[list[float]]]:
    world.simulation.physics_calls.refuse("a vision sensor cannot be read", step_only=True)
    try:
        future = world.vision.read(handle)
    except CommandError:
        return False, []  # the sensor has not been handled
    return wait_for(world.simulation, future)


def _packet(place: int) -> Any:
    def get(world: World, handle: int) -> list[float]:
        packets = _reading(world, handle)[1]
        return packets[place] if place < len(packets) else []

    return get


def _set_resolution(world: World, handle: int, sides: list[int]) -> None:
    world.vision.change(handle, width=sides[0], height=sides[1])


VISION = (
    *CAMERAS,
    drawn_size("sensorSize", DrawnSize.SENSOR, 0.01),
    Property(
        "resolution",
        INT_ARRAY2,
        lambda world, handle: [_settings(world, handle).width, _settings(world, handle).height],
        _set_resolution,
    ),
    numbered("renderMode", INT, "visionintparam_render_mode"),
    Property("backgroundColor", COLOR, _background, _set_background),
    Property(
        "backgroundColorFromEnvironment",
        BOOL,
        lambda world, handle: _settings(world, handle).background is None,
        _set_from_environment,
    ),
    Property(
        "explicitHandling",
        BOOL,
        lambda world, handle: _settings(world, handle).explicit,
        lambda world, handle, on: world.vision.set_explicit(handle, on),
    ),
    _switch("useExtImage", "external"),
    _switch("ignoreImageInfo", "has_rgb", inverted=True),
    _switch("ignoreDepthInfo", "has_depth", inverted=True),
    _switch("omitPacket1", "has_statistics", inverted=True),
    Property(
        "imageBuffer",
        BUFFER,
        _image,
        lambda world, handle, image: vision.set_vision_sensor_image(world, handle, image, 0),
        is_large=True,
    ),
    Property(
        "depthBuffer",
        FLOAT_ARRAY,
        lambda world, handle: np.frombuffer(_depth(world, handle), "<f4").tolist(),
        is_large=True,
    ),
    Property("packedDepthBuffer", BUFFER, _depth, is_large=True),
    Property("triggerState", BOOL, lambda world, handle: _reading(world, handle)[0], waits=True),
    Property("packet1", FLOAT_ARRAY, _packet(0), waits=True),
    Property("packet2", FLOAT_ARRAY, _packet(1), waits=True),
)
"""Images are rows of RGB bytes, the lowest first; the depth is 0 at the near clipping plane, 1 at the far one."""
