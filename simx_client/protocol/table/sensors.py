"""Proximity, force and vision sensors."""

from __future__ import annotations

from ..kinds import BOOL, DEPTHS, INT, PACKETS, VECTOR3
from .command import Command, Effect
from .meanings import (
    FORCE_SENSOR_HANDLE,
    HANDLE_OR_NONE,
    IMAGE,
    IMAGE_OPTIONS,
    PROXIMITY_SENSOR_HANDLE,
    RESOLUTION,
    VISION_SENSOR_HANDLE,
    Meaning,
)

SENSORS = (
    Command(
        name="simxReadProximitySensor",
        takes={"sensorHandle": PROXIMITY_SENSOR_HANDLE},
        gives={
            "detectionState": Meaning(BOOL, "whether something is detected"),
            "detectedPoint": Meaning(VECTOR3, "m, in the sensor's frame"),
            "detectedObjectHandle": HANDLE_OR_NONE,
            "detectedSurfaceNormalVector": Meaning(VECTOR3, "unit vector, in the sensor's frame"),
        },
        doc="Return the detected point and the unit normal in the sensor's frame, in metres.",
        effect=Effect.READS,
        key=("sensorHandle",),
        legacy_id=0x1009,
        twin="sim.readProximitySensor",
    ),
    Command(
        name="simxReadForceSensor",
        takes={"forceSensorHandle": FORCE_SENSOR_HANDLE},
        gives={
            "state": Meaning(INT, "bit 0: there is data, bit 1: broken"),
            "forceVector": Meaning(VECTOR3, "N, in the sensor's frame"),
            "torqueVector": Meaning(VECTOR3, "N m, in the sensor's frame"),
        },
        doc="Return force and torque in the sensor's frame; state bit 0: data available, bit 1: broken.",
        effect=Effect.READS,
        key=("forceSensorHandle",),
        legacy_id=0x100F,
        twin="sim.readForceSensor",
    ),
    Command(
        name="simxBreakForceSensor",
        takes={"forceSensorHandle": FORCE_SENSOR_HANDLE},
        doc="Break a force sensor.",
        effect=Effect.EDITS,
        key=("forceSensorHandle",),
        legacy_id=0x1010,
        twin="sim.breakForceSensor",
    ),
    Command(
        name="simxReadVisionSensor",
        takes={"sensorHandle": VISION_SENSOR_HANDLE},
        gives={
            "detectionState": Meaning(BOOL, "whether something is detected"),
            "auxPackets": Meaning(
                PACKETS, "15 statistics of the image, then the results of the sensor's script"
            ),
        },
        doc=(
            "Return statistics of the image: least, greatest and mean intensity, red, green, blue and depth."
        ),
        effect=Effect.READS,
        key=("sensorHandle",),
        makes_image=True,
        legacy_id=0x1011,
        twin="sim.readVisionSensor",
    ),
    Command(
        name="simxGetVisionSensorImage",
        takes={"sensorHandle": VISION_SENSOR_HANDLE, "options": IMAGE_OPTIONS},
        gives={"resolution": RESOLUTION, "image": IMAGE},
        doc="Return the image as signed bytes, bottom row first, RGB or grey with option bit 0.",
        effect=Effect.READS,
        key=("sensorHandle", "options"),
        makes_image=True,
        legacy_id=0x1004,
        twin="sim.getVisionSensorImg",
    ),
    Command(
        name="simxSetVisionSensorImage",
        takes={"sensorHandle": VISION_SENSOR_HANDLE, "image": IMAGE, "options": IMAGE_OPTIONS},
        doc="Replace a sensor's image.",
        effect=Effect.CHANGES,
        key=("sensorHandle", "options"),
        legacy_id=0x1006,
        twin="sim.setVisionSensorImg",
    ),
    Command(
        name="simxGetVisionSensorDepthBuffer",
        takes={"sensorHandle": VISION_SENSOR_HANDLE},
        gives={
            "resolution": RESOLUTION,
            "buffer": Meaning(DEPTHS, "0 near plane .. 1 far plane, bottom row first"),
        },
        doc="Return depths 0..1, linear between the clipping planes along the view axis, bottom row first.",
        effect=Effect.READS,
        key=("sensorHandle",),
        makes_image=True,
        legacy_id=0x1017,
        twin="sim.getVisionSensorDepth",
    ),
)
