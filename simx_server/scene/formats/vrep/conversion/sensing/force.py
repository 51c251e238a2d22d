"""Force sensors: a site with a force and a torque sensor."""

from __future__ import annotations

import mujoco

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.numbers import within
from simx_server.scene.formats.vrep.objects import ForceSensor
from simx_server.scene.poses.poses import Pose

from .proximity import SENSOR_GROUP

_LEAST_LOAD = 1e-9
"""N or N m: a threshold of 0 breaks under any load."""


def add_force_sensor(conversion: Conversion, sensor: ForceSensor, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a force sensor; it measures between the body and its parent.

    Args:
        conversion: the conversion.
        sensor: the sensor.
        body: the body that it holds.
        at: its frame in that body.
    """
    name = conversion.name(sensor)
    body.add_site(
        name=name,
        pos=at[0],
        quat=at[1],
        group=SENSOR_GROUP,
        size=[within(sensor.size, 1e-4, 1.0, 0.01) / 2] * 3,
    )
    for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
        conversion.spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name)
    limits = sensor.max_force is not None or sensor.max_torque is not None
    conversion.annotate(
        "force",
        name,
        max_force=_load(sensor.max_force),
        max_torque=_load(sensor.max_torque),
        violations=int(within(sensor.violations, 1, 10_000, 1)) if limits else None,
        overload="trigger" if limits and not sensor.breaks else None,
        samples=int(within(sensor.samples, 1, 10_000, 1)),
        filter=sensor.filter if sensor.filter == "median" else None,
    )


def _load(threshold: float | None) -> float | None:
    return None if threshold is None else within(threshold, _LEAST_LOAD, 1e12, 1e12)
