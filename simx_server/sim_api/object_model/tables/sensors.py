"""Properties of proximity sensors, vision sensors, cameras and force sensors."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from simx_server.sim_api.object_model.types import MATRIX
from simx_server.sim_api.object_model.values import Matrix
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed, numbered
from simx_server.sim_api.properties.tables.sensors import FORCE, PROXIMITY
from simx_server.sim_api.properties.tables.vision import CAMERAS, VISION

from .making import Old, kept, kept_colors, refused

if TYPE_CHECKING:
    from simx_server.world.world import World

_PROXIMITY, _VISION, _FORCE = Old(PROXIMITY), Old(VISION), Old(FORCE)
_CAMERA = Old(CAMERAS)
_EXACT = "volumes are exact, and have no facets"

PROXIMITY_SENSOR = (
    *_PROXIMITY.same(
        "angleThreshold closeThreshold backFaceDetection frontFaceDetection exactMode explicitHandling"
    ),
    *_PROXIMITY.same("randomizedDetection showVolume detectedNormal detectedPoint detectedObject"),
    _PROXIMITY.worded("sensorType", "proximitySensor.type", "proximitySensorType"),
    _PROXIMITY.named("volume_offset", "volume.offset"),
    _PROXIMITY.named("volume_range", "volume.range"),
    _PROXIMITY.named("volume_angle", "volume.angle"),
    _PROXIMITY.named("volume_radius", "volume.radius"),
    _PROXIMITY.named("volume_xSize", "volume.xSize"),
    _PROXIMITY.named("volume_ySize", "volume.ySize"),
    *(refused(f"volume.{name}", t.FLOAT_ARRAY, _EXACT) for name in ("edges", "closeEdges")),
    *(refused(f"volume.{name}", t.INT_ARRAY, _EXACT) for name in ("faces", "subdivisions")),
    kept("pointSize", t.FLOAT, 0.01),
    *kept_colors("color"),
    *kept_colors("rayColor"),
)

_NO_RAYS = "images are not rendered by POV-Ray"


def _depth(world: World, handle: int) -> Matrix:
    """Return the distances as rows of the image, the lowest first."""
    get, settings = _VISION["depthBuffer"].get, world.vision.settings(handle)
    assert get is not None
    return Matrix(settings.height, settings.width, get(world, handle))


def _packed_depth(world: World, handle: int) -> bytes:
    numbers = _depth(world, handle).numbers
    return struct.pack(f"<{len(numbers)}f", *numbers)


VISION_SENSOR = (
    *_VISION.same(
        "backgroundColor backgroundColorFromEnvironment clippingPlanes explicitHandling perspective"
    ),
    *_VISION.same(
        "frustumCornerFar frustumCornerNear ignoreDepthInfo ignoreImageInfo omitPacket1 packet1 packet2"
    ),
    *_VISION.same("resolution showFrustum triggerState useExtImage viewAngle viewSize"),
    _VISION.named("imageBuffer", "image"),
    Property("depth", MATRIX, _depth, is_large=True),
    Property("packedDepth", t.BUFFER, _packed_depth, is_large=True),
    _VISION.enumerated("renderMode", "renderMode", "renderMode"),
    fixed("emitDepthChangedEvent", t.BOOL, False, "there are no events of images"),
    fixed("emitImageChangedEvent", t.BOOL, False, "there are no events of images"),
    *(refused(f"povray.{name}", t.FLOAT, _NO_RAYS) for name in ("aperture", "blurDistance")),
    refused("povray.blurSamples", t.INT, _NO_RAYS),
    fixed("povray.focalBlur", t.BOOL, False, _NO_RAYS),
    kept("size", t.FLOAT, 0.01),
    *kept_colors("color"),
)

CAMERA = (
    *_CAMERA.same(
        "clippingPlanes frustumCornerFar frustumCornerNear perspective showFrustum viewAngle viewSize"
    ),
    kept("resolution", t.INT_ARRAY2, [256, 256]),
    numbered("trackedObject", t.HANDLE, "cameraintparam_trackedobject"),
    kept("parentAsManipulationProxy", t.BOOL, False),
    kept("rotationEnabled", t.BOOL, True),
    kept("translationEnabled", t.BOOL, True),
    kept("size", t.FLOAT, 0.05),
    *kept_colors("color"),
)

FORCE_SENSOR = (
    *_FORCE.same("consecutiveViolationsToTrigger filterSampleSize forceThreshold forceThresholdEnabled"),
    *_FORCE.same("torqueThreshold torqueThresholdEnabled"),
    _FORCE.enumerated("filterType", "filter", "forceSensorFilter"),
    _FORCE.named("sensorForce", "force"),
    _FORCE.named("sensorTorque", "torque"),
    _FORCE.named("filteredSensorForce", "filteredForce"),
    _FORCE.named("filteredSensorTorque", "filteredTorque"),
    # Its two sides are one body here.
    Property("intrinsicError", t.POSE, lambda _world, _handle: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
    kept("size", t.FLOAT, 0.01),
    *kept_colors("color"),
)
