"""Scripts that process images (``sysCall_vision``), and scripts that are called on detections (``sysCall_trigger``).

A trigger is a detection by a vision or proximity sensor, or the overload of a force sensor.

A vision sensor whose script has one of the two is rendered in each simulation step, after physics and before the
scripts' sensing; all others are rendered on request. The first packet is of the image as rendered; the script's
result decides whether the sensor detects, and its packets follow. For a sensor with explicit handling or external
input, the script is called when a script handles the sensor, or when an image is set. Of a child and a customization
script the first one with a result decides.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.sensors.vision.vision_settings import Verdict

from .images import wait_for

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar
    from simx_server.scripting.interpreter import Plain
    from simx_server.scripting.script import Script
    from simx_server.sensors.force import ForceSensors
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.sensors.vision.vision_sensors import VisionSensors
    from simx_server.simulation.simulation import Simulation

VISION = "sysCall_vision"
TRIGGER = "sysCall_trigger"

Notify = Callable[..., list[Any] | None]
"""Calls a function of an object's scripts (handle, function, arguments) and returns the first result of any of them."""


class VisionCallBacks:
    """The sensors with such scripts."""

    def __init__(
        self,
        sim: Simulation,
        notify: Notify,
        status_bar: StatusBar,
        vision: VisionSensors,
        proximity: ProximitySensors,
        force: ForceSensors,
    ) -> None:
        self._sim = sim
        self._status_bar = status_bar
        self._vision = vision
        self._proximity = proximity
        self._force = force
        self._notify = notify
        self._judged: frozenset[int] = frozenset()
        self._told: frozenset[int] = frozenset()
        self._asked: set[int] = set()
        """Sensors whose scripts are processing an image now: an image that such a script sets is not processed again.
        """

    @property
    def has_work(self) -> bool:
        """Return whether scripts process images, or are called on detections."""
        return bool(self._judged or self._told)

    def watch(self, scripts: Sequence[Script]) -> None:
        """Update the list of sensors after scripts have started or ended."""
        self._judged = frozenset(one.owner for one in scripts if one.has(VISION))
        self._told = frozenset(one.owner for one in scripts if one.has(TRIGGER))
        self._vision.tell_images(self._judge)
        self._sim.parts.replan()

    def sense(self) -> None:
        """Process the images of a simulation step: all are requested before the first script waits for one."""
        sim = self._sim
        concerned = self._judged | self._told
        sensors = [one for one in sim.scene.of_kind(ObjectKind.VISION_SENSOR) if one in concerned]
        for handle in [handle for handle in sensors if self._vision.sense(handle)]:
            self._judge(handle)
        for handle in sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR):
            if handle in self._told:
                self._tell_of_proximity(handle)
        for handle, reading in self._force.overloaded.items():
            if handle in self._told:
                known = {"handle": handle, "force": list(reading.force), "torque": list(reading.torque)}
                self._notify(handle, TRIGGER, known)

    def _judge(self, handle: int) -> None:
        """Process a sensor's new image."""
        if handle not in self._judged | self._told or handle in self._asked:
            return
        self._asked.add(handle)
        try:
            self._vision.judge(handle, self._verdict(handle))
            if handle in self._told:
                self._tell_of_vision(handle)
        finally:
            self._asked.discard(handle)

    def _verdict(self, handle: int) -> Verdict:
        if handle not in self._judged:
            return Verdict(None)
        answer = _table(self._notify(handle, VISION, self._known(handle)))
        packets: Plain = answer.get("packedPackets")
        found: list[Any] = packets if isinstance(packets, list) else []
        detects = answer.get("trigger")
        return Verdict(
            None if detects is None else bool(detects),
            tuple(_numbers(packet) for packet in found if isinstance(packet, bytes)),
        )

    def _known(self, handle: int) -> dict[str, Any]:
        settings = self._vision.settings(handle)
        return {
            "handle": handle,
            "resolution": [settings.width, settings.height],
            "clippingPlanes": [settings.near, settings.far],
            "viewAngle": settings.angle,
            "orthoSize": settings.size,
            "perspectiveOperation": settings.is_perspective,
        }

    def _tell_of_vision(self, handle: int) -> None:
        sim = self._sim
        try:
            detects, packets = wait_for(sim, self._vision.read(handle))
        except CommandError as problem:
            self._status_bar.add(f"{TRIGGER} of '{sim.scene.get(handle).name}' is not called: {problem}")
            return
        if not detects:
            return
        packed = [struct.pack(f"<{len(packet)}f", *packet) for packet in packets]
        answer = _table(self._notify(handle, TRIGGER, {"handle": handle, "packedPackets": packed}))
        if answer.get("trigger") is False:
            self._vision.judge(handle, Verdict(False, tuple(packets[1:])))

    def _tell_of_proximity(self, handle: int) -> None:
        try:
            found = self._proximity.read(handle)
        except CommandError:
            return  # the sensor has explicit handling and was not handled yet
        if found is not None:
            known = {
                "handle": handle,
                "detectedObjectHandle": found.handle,
                "detectedPoint": list(found.point),
                "normalVector": list(found.normal),
            }
            self._notify(handle, TRIGGER, known)


def _table(results: list[Plain] | None) -> dict[Any, Any]:
    """Return the first result if it is a table with names."""
    return results[0] if results and isinstance(results[0], dict) else {}


def _numbers(packet: bytes) -> list[float]:
    """Return the numbers of sim.packFloatTable; a rest of less than four bytes is ignored."""
    return list(struct.unpack_from(f"<{len(packet) // 4}f", packet))
