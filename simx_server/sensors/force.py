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
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
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
        """Of the sensors that are, or were, measured in each simulation step."""
        self._broken: set[int] = set()
        self._values: NDArray[np.float64] | None = None
        """MuJoCo's `sensordata`, mean over the last simulation step; None: there was none with dynamics."""
        self._places: dict[int, slice | NDArray[np.intp]] = {}
        """Where force and torque of each sensor are in it: six numbers."""
        self._carried: dict[int, NDArray[np.float64]] = {}
        """Measurements in the last simulation step, of another model than the present one."""
        self._remembering: list[SceneObject] = []
        """The sensors that are measured in each simulation step: they average several, or may break."""
        self._annotations: object = None
        """The scene's annotations with which places and sensors were found; None: the model is another one."""
        self.overloaded: dict[int, ForceReading] = {}
        """The sensors whose scripts are to be called in this simulation step, and what they measure."""

    def run_started(self) -> None:
        self._forget()

    def run_stopped(self) -> None:
        self._forget()

    def scene_changed(self) -> None:
        self._forget()

    def model_changed(self, twins: Twins | None) -> None:
        self._carried = self._last_measurements()
        self._places.clear()
        self._values = self._annotations = None

    def object_scaled(self, handle: int, factor: float) -> None:
        if self._sim.scene.get(handle).kind == ObjectKind.FORCE_SENSOR:
            powers = {"max_force": 3, "max_torque": 4}
            renaming.scale_annotation(self._sim, handle, "force", powers, factor)

    def remember(self) -> object:
        samples = {handle: ((tuple(each.tolist()),), 0) for handle, each in self._last_measurements().items()}
        if not samples and not self._records and not self._broken:
            return None
        records = {
            handle: (tuple(tuple(sample.tolist()) for sample in each.samples), each.violations)
            for handle, each in self._records.items()
        }
        return samples | records, frozenset(self._broken)

    def recall(self, memory: Any) -> None:
        if memory is None:
            self._forget()
            return
        records: Mapping[int, tuple[tuple[tuple[float, ...], ...], int]]
        records, broken = memory
        self._forget()
        self._broken.update(broken)
        for handle, (samples, violations) in records.items():
            item = self._sim.scene.objects[handle]
            if _is_remembering(item):
                record = self._renew(item, None)
                record.samples.extend(map(np.array, samples))
                record.violations = violations
            elif samples:
                self._carried[handle] = np.array(samples[-1])

    def read(self, handle: int) -> ForceReading | None:
        """Return the last measurement, filtered.

        Returns:
            None before there are enough samples for the filter, when broken, without dynamics and while stopped.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        samples = self._samples_of(handle)
        if handle in self._broken or len(samples) < _samples(item):
            return None
        x, y, z, a, b, c = _filtered(item, samples).tolist()
        return ForceReading((x, y, z), (a, b, c))

    def newest(self, handle: int) -> ForceReading | None:
        """Return the last measurement before the filter; None when broken, without dynamics and while stopped.

        Raises:
            UnknownHandle, WrongKind: the handle is not a force sensor's.
        """
        self._sim.scene.get_kind(handle, ObjectKind.FORCE_SENSOR)
        samples = self._samples_of(handle)
        if handle in self._broken or not samples:
            return None
        x, y, z, a, b, c = samples[-1].tolist()
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

    @property
    def has_work(self) -> bool:
        """Return whether the scene has force sensors."""
        return bool(self._sim.scene.of_kind(ObjectKind.FORCE_SENSOR))

    def sense(self) -> None:
        """Note the values of a simulation step, from which a sensor is measured when it is read."""
        sim = self._sim
        if self.overloaded:
            self.overloaded.clear()
        if not sim.dynamics_enabled:
            self._records.clear()
            self._carried.clear()
            self._values = None
            return
        if self._annotations is not sim.scene.annotations:
            self._find()
        self._values = sim.joints.controllers.mean_sensed.copy()
        if self._carried:
            self._carried.clear()
        if self._remembering:
            self._measure()

    def _measure(self) -> None:
        """Measure the sensors that remember earlier steps; break those under too much load."""
        assert self._values is not None
        failing: list[int] = []
        for item in self._remembering:
            handle, note = item.handle, _note(item)
            record = self._records.get(handle)
            if record is None or record.note is not note:
                record = self._renew(item, record)
            record.samples.append(-self._values[self._places[handle]])
            if not record.has_threshold or not self._is_overloaded(item, record):
                continue
            reading = self.read(handle)
            if note.get("overload", "break") == "break":
                failing.append(handle)
            elif reading is not None:
                self.overloaded[handle] = reading
        for handle in failing:
            logger.info("force sensor '%s' breaks under its load", self._sim.scene.get(handle).name)
            self.break_apart(handle)

    def _find(self) -> None:
        """Find where the values of the sensors are, and which sensors remember earlier steps."""
        scene, places = self._sim.scene, self._sim.model.sensor_adr
        items = [scene.objects[handle] for handle in scene.of_kind(ObjectKind.FORCE_SENSOR)]
        self._remembering = [each for each in items if each.handle in self._records or _is_remembering(each)]
        for item in self._remembering:
            if item.handle not in self._records:
                self._renew(item, None).samples.extend(self._samples_of(item.handle))
        for item in items:
            force, torque = places[list(item.sensors)].tolist()
            is_one = torque == force + 3
            self._places[item.handle] = (
                slice(force, force + 6) if is_one else np.r_[force : force + 3, torque : torque + 3]
            )
        self._annotations = scene.annotations

    def _samples_of(self, handle: int) -> Sequence[NDArray[np.float64]]:
        """Return the measurements that a sensor has."""
        if (record := self._records.get(handle)) is not None:
            return record.samples
        if (carried := self._carried.get(handle)) is not None:
            return [carried]
        if self._values is None or handle not in self._places:
            return []
        return [-self._values[self._places[handle]]]

    def _last_measurements(self) -> dict[int, NDArray[np.float64]]:
        """Return what the sensors without a record have measured in the last simulation step."""
        handles = [handle for handle in {**self._carried, **self._places} if handle not in self._records]
        return {handle: samples[-1] for handle in handles if (samples := self._samples_of(handle))}

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

    def _is_overloaded(self, item: SceneObject, record: _Record) -> bool:
        """Count the simulation steps in which a threshold is reached; return whether the sensor breaks."""
        note = _note(item)
        if item.handle in self._broken or len(record.samples) < _samples(item):
            return False
        filtered = _filtered(item, record.samples)
        too_much = any(
            key in note and float(np.linalg.norm(part)) >= float(note[key])
            for key, part in (("max_force", filtered[:3]), ("max_torque", filtered[3:]))
        )
        record.violations = record.violations + 1 if too_much else 0
        return record.violations >= int(note.get("violations", DEFAULT_VIOLATIONS))

    def _forget(self) -> None:
        self._records.clear()
        self._carried.clear()
        self._values = self._annotations = None
        self._broken.clear()
        self.overloaded.clear()


_NOTHING: Annotation = {}


def _note(item: SceneObject) -> Annotation:
    return item.annotations.get("force", _NOTHING)


def _samples(item: SceneObject) -> int:
    return int(_note(item).get("samples", 1))


def _is_remembering(item: SceneObject) -> bool:
    """Return whether a sensor needs more than the values of the last simulation step."""
    note = _note(item)
    return _samples(item) > 1 or "max_force" in note or "max_torque" in note


def _filtered(item: SceneObject, measured: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return (6,): mean, or per component the median (of an even number the upper median, as in V-REP)."""
    samples = np.array(measured)
    if _note(item).get("filter", "average") == "median":
        return np.sort(samples, axis=0)[len(samples) // 2]
    return samples.mean(axis=0)
