"""Force sensors: sites with a force and a torque sensor.

Axes are the site's. The sign is V-REP's: what the far side (the child) exerts on the near side, so a weight that
hangs on a sensor whose z points up reads -m g. MuJoCo's sensors give the opposite; V-REP's own MuJoCo engine
negates them.

As in V-REP a value is the mean over the physics steps of a simulation step, and reading filters over the last
`samples` simulation steps (1 unless annotated). A sensor breaks when `max_force` or `max_torque` is exceeded in
`violations` consecutive simulation steps; with `overload=trigger` its script is called instead, in each such step.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.editing import renaming
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.poses.poses import Vector
from simx_server.simulation.part import Part

from ..errors import CommandError
from ..scene.breaking import break_sensor
from ..scene.objects import ObjectKind, SceneObject

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

DEFAULT_VIOLATIONS = 10
"""Default number of simulation steps in which a threshold must be exceeded, as in V-REP."""


@dataclass(frozen=True, slots=True)
class ForceReading:
    """Newtons and newton metres in the sensor's axes."""

    force: Vector
    torque: Vector


@dataclass
class _Record:
    """The measurements of one sensor in the last simulation steps: (6,) force and torque each."""

    samples: deque[NDArray[np.float64]]
    note: Annotation
    """The sensor's annotation of which the next field is known; another annotation is another object."""
    has_threshold: bool
    violations: int = 0


class ForceSensors(Part):
    """All force sensors of the scene."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._records: dict[int, _Record] = {}
        self._broken: set[int] = set()
        self._places: dict[int, slice | NDArray[np.intp]] = {}
        """Where force and torque of each sensor are in MuJoCo's `sensordata`: six numbers."""
        self.overloaded: dict[int, ForceReading] = {}
        """The sensors whose scripts are to be called in this simulation step, and what they measure."""

    def run_started(self) -> None:
        self._forget()

    def run_stopped(self) -> None:
        self._forget()

    def scene_changed(self) -> None:
        self._forget()

    def model_changed(self, twins: Twins | None) -> None:
        self._places.clear()

    def object_scaled(self, handle: int, factor: float) -> None:
        if self._sim.scene.get(handle).kind == ObjectKind.FORCE_SENSOR:
            powers = {"max_force": 3, "max_torque": 4}
            renaming.scale_annotation(self._sim, handle, "force", powers, factor)

    def remember(self) -> object:
        if not self._records and not self._broken:
            return None
        records = {
            handle: (tuple(tuple(sample.tolist()) for sample in each.samples), each.violations)
            for handle, each in self._records.items()
        }
        return records, frozenset(self._broken)

    def recall(self, memory: Any) -> None:
        if memory is None:
            self._forget()
            return
        records: Mapping[int, tuple[tuple[tuple[float, ...], ...], int]]
        records, self._broken = memory[0], set(memory[1])
        self._records = {}
        for handle, (samples, violations) in records.items():
            record = self._renew(self._sim.scene.objects[handle], None)
            record.samples.extend(map(np.array, samples))
            record.violations = violations

    def read(self, handle: int) -> ForceReading | None:
        """Return the last measurement, filtered.

        Returns:
            None before there are enough samples for the filter, when broken, without dynamics and while stopped.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        record = self._records.get(handle)
        if record is None or handle in self._broken or len(record.samples) < _samples(item):
            return None
        x, y, z, a, b, c = _filtered(item, record).tolist()
        return ForceReading((x, y, z), (a, b, c))

    def newest(self, handle: int) -> ForceReading | None:
        """Return the last measurement before the filter; None when broken, without dynamics and while stopped.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
        """
        self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        record = self._records.get(handle)
        if record is None or handle in self._broken or not record.samples:
            return None
        x, y, z, a, b, c = record.samples[-1].tolist()
        return ForceReading((x, y, z), (a, b, c))

    def violations_to_trigger(self, handle: int) -> int:
        """Return the number of simulation steps in which a threshold must be exceeded.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        return int(_note(item).get("violations", DEFAULT_VIOLATIONS))

    def is_broken(self, handle: int) -> bool:
        """Return whether the sensor has broken in this run.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
        """
        self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        return handle in self._broken

    def break_apart(self, handle: int) -> None:
        """Release what the sensor holds; do nothing if that was done already.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
            CommandError: the simulation is stopped.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        if not self._sim.is_running:
            raise CommandError(
                f"force sensor '{item.name}' can be broken only while the simulation runs; start it"
            )
        if handle not in self._broken:
            break_sensor(self._sim, item)
            self._broken.add(handle)

    def sense(self) -> None:
        self.overloaded.clear()
        sim = self._sim
        handles = sim.scene.of_kind(ObjectKind.FORCE_SENSOR)
        if not handles:
            return
        if not sim.dynamics_enabled:
            self._records.clear()
            return
        values, objects, records, places = (
            sim.joints.mean_sensed,
            sim.scene.objects,
            self._records,
            self._places,
        )
        failing: list[int] = []
        for handle in handles:
            item = objects[handle]
            note = _note(item)
            record = records.get(handle)
            if record is None or record.note is not note:
                record = self._renew(item, record)
            place = places.get(handle)
            record.samples.append(-values[self._find(item) if place is None else place])
            if not record.has_threshold or not self._is_overloaded(item, record):
                continue
            reading = self.read(handle)
            if note.get("overload", "break") == "break":
                failing.append(handle)
            elif reading is not None:
                self.overloaded[handle] = reading
        for handle in failing:
            logger.info("force sensor '%s' breaks under its load", sim.scene.get(handle).name)
            self.break_apart(handle)

    def _renew(self, item: SceneObject, record: _Record | None) -> _Record:
        """Return the record of a sensor that has none, or whose annotation has changed."""
        note, count = _note(item), _samples(item)
        has_threshold = "max_force" in note or "max_torque" in note
        if record is None:
            record = _Record(deque(maxlen=count), note, has_threshold)
        else:
            record.note, record.has_threshold = note, has_threshold
            if record.samples.maxlen != count:
                record = _Record(deque(record.samples, maxlen=count), note, has_threshold)
        self._records[item.handle] = record
        return record

    def _find(self, item: SceneObject) -> slice | NDArray[np.intp]:
        """Find where the values of a sensor are."""
        force, torque = self._sim.model.sensor_adr[list(item.sensors)].tolist()
        place = self._places[item.handle] = (
            slice(force, force + 6) if torque == force + 3 else np.r_[force : force + 3, torque : torque + 3]
        )
        return place

    def _is_overloaded(self, item: SceneObject, record: _Record) -> bool:
        """Count the simulation steps in which a threshold is reached; return whether the sensor breaks."""
        note = _note(item)
        if item.handle in self._broken or len(record.samples) < _samples(item):
            return False
        filtered = _filtered(item, record)
        too_much = any(
            key in note and float(np.linalg.norm(part)) >= float(note[key])
            for key, part in (("max_force", filtered[:3]), ("max_torque", filtered[3:]))
        )
        record.violations = record.violations + 1 if too_much else 0
        return record.violations >= int(note.get("violations", DEFAULT_VIOLATIONS))

    def _forget(self) -> None:
        self._records.clear()
        self._broken.clear()
        self.overloaded.clear()


_NOTHING: Annotation = {}


def _note(item: SceneObject) -> Annotation:
    return item.annotations.get("force", _NOTHING)


def _samples(item: SceneObject) -> int:
    return int(_note(item).get("samples", 1))


def _filtered(item: SceneObject, record: _Record) -> NDArray[np.float64]:
    """Return (6,): mean, or per component the median (of an even number the upper median, as in V-REP)."""
    samples = np.array(record.samples)
    if _note(item).get("filter", "average") == "median":
        return np.sort(samples, axis=0)[len(samples) // 2]
    return samples.mean(axis=0)
