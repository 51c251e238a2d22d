"""Write the events of a simulation to a state log: the listener on the physics thread.

Times in the log are the wall clock's at its start plus the simulated time since, of all runs one after the other. So a
viewer plays it in simulated time, and pauses between runs take no time. The times of a replay start as those of the
recording did.

Where the log cannot keep up, simulation steps are left out in real time and counted; at ``--speed max`` and in stepped
mode the next step comes when there is space, as with films.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.joints.joints import JOINT_TYPES
from simx_server.outputs.filming.film import MOST_FPS
from simx_server.outputs.filming.shot import Shot, first_image
from simx_server.scene.objects import ObjectKind
from simx_server.simulation.part import Part

from .images import Images
from .mcap_file import McapWriter
from .messages import plain, set_time
from .packed import Packed
from .poses import Places
from .shapes import scene_update

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

ROOT = "world"
"""The frame in which all others are given."""

MOST_WAITING = 2000
"""Messages that may wait for the writing thread; a simulation step makes five."""

LOOKS_EVERY = 1.0
"""Simulated seconds between two descriptions of the scene while its model is edited repeatedly."""

INFO, ERROR = 2, 4
"""Levels of `foxglove.Log`."""

_SIGNALS = {"integers": "IntegerSignal", "floats": "FloatSignal", "strings": "StringSignal"}
_LONGEST_TEXT = 10_000


class StateLog(Part):
    """Listens to a simulation. Physics thread only. Close it at the end, before rendering is closed."""

    def __init__(
        self,
        world: World,
        path: Path,
        shot: Shot | None = None,
        fps: float | None = None,
        *,
        began: int | None = None,
    ) -> None:
        """Start a log.

        Args:
            shot: the camera for images in the log; None: no images.
            fps: images per simulated second; None: one for each simulation step, MOST_FPS at most.
            ``began``: nanoseconds since 1970 at simulated time zero; None: now.

        Raises:
            OutputError: the file cannot be written, or a package is missing.
            CommandError: images cannot be made here.
        """
        sim = world.simulation
        self._sim = sim
        self._status_bar = world.status_bar
        self._present_signals = world.signals
        if shot is not None:
            first_image(shot)
        self._writer = McapWriter(path)
        self._images = None if shot is None else Images(shot, fps or MOST_FPS, self._writer)
        self._zero = time.time_ns() if began is None else began
        self._before = 0.0
        """Simulated seconds of the runs that are over."""

        self._is_counted = True
        """The present run's time is included."""

        self._run = 0
        self.left_out = 0
        """Simulation steps that are not in the log because writing could not keep up."""

        self._is_broken = False
        self._told = world.status_bar.count
        self._signals: dict[str, dict[str, Any]] = {kind: {} for kind in _SIGNALS}
        self._looks = b""
        self._looks_at = -math.inf
        self._model: mujoco.MjModel | None = None
        self._placed = self._looked = -1
        """The model's version when its poses and its appearance were found."""

        self._places: Places
        self._frame_names: list[str] = []
        self._frames: Packed
        self._joints: tuple[list[int], Packed]
        self._sample()
        sim.parts.attach(self)

    def close(self) -> None:
        """Write what waits, and end the file."""
        self._tell_messages()
        if self._images is not None:
            self._images.finish()
        self._writer.close()
        if not self._writer.has_failed:
            logger.info(
                "'%s' has %d messages, %.2f s of simulated time; %d steps and %d images were left out, as writing "
                "and rendering could not keep up",
                self._writer.path, self._writer.written, (self._now - self._zero) / 1e9, self.left_out,
                self.unseen,
            )  # fmt: skip

    def run_started(self) -> None:
        self._run += 1
        self._is_counted = False
        self._sample()

    def run_stopping(self) -> None:
        self._before += self._sim.time
        self._is_counted = True

    def step_finished(self) -> None:
        if self._writer.has_failed:
            return
        if self._is_full():
            self.left_out += 1
            return
        self._sample()

    def _is_full(self) -> bool:
        return not self._writer.has_failed and self._writer.waiting >= MOST_WAITING

    def holds_step(self) -> bool:
        return self._is_full() or (self._images is not None and self._images.are_awaited)

    def run_paused(self) -> None:
        self._sample()

    def run_resumed(self) -> None:
        self._sample()

    def run_stopped(self) -> None:
        self._sample()

    def scene_changed(self) -> None:
        self._sample()

    def script_stopped(self, problem: str) -> None:
        self._tell(ERROR, problem)

    @property
    def unseen(self) -> int:
        """Return the number of images that are not in the log because rendering failed or could not keep up."""
        return 0 if self._images is None else self._images.unseen

    @property
    def _now(self) -> int:
        """Return the log's time in nanoseconds since 1970."""
        elapsed = self._before + (0.0 if self._is_counted else self._sim.time)
        return self._zero + round(elapsed * 1e9)

    # --- samples ---------------------------------------------------------------------------------

    def _sample(self) -> None:
        """Log the present state. An error of the log does not end a run."""
        if self._is_broken or self._writer.has_failed:
            return
        try:
            self._note_all()
        except Exception:
            self._is_broken = True
            logger.exception("the state log '%s' ends here; the server goes on", self._writer.path)

    def _note_all(self) -> None:
        sim, now = self._sim, self._now
        sim.refresh()
        self._tell_state(now)
        self._learn(now)
        state, places = self._places.state(sim), self._places
        frames, (handles, joints) = self._frames, self._joints
        self._put("/tf", "foxglove.FrameTransforms", now, lambda: frames.filled(places.poses(state), now))
        if handles:
            values = [
                number(handle) for handle in handles for number in (sim.joints.position, sim.joints.velocity)
            ]
            self._put("/joints", "foxglove.JointStates", now, lambda: joints.filled(np.array(values), now))
        self._tell_signals(now)
        self._tell_messages()
        if self._images is not None:
            self._images.take((now - self._zero) * 1e-9, now)

    def _put(self, topic: str, schema: str, now: int, make: Callable[[], bytes]) -> None:
        self._writer.put(topic, schema, now, make)

    def _send(self, topic: str, schema: str, now: int, **fields: Any) -> None:
        message = self._writer.messages.new(schema)
        set_time(message.timestamp, now)
        for name, value in fields.items():
            setattr(message, name, plain(value) if isinstance(value, str) else value)
        self._put(topic, schema, now, message.SerializeToString)

    def _tell_state(self, now: int) -> None:
        sim = self._sim
        self._send(
            "/simulation", "simx.Simulation", now, state=sim.state.value, scene=sim.scene.name, run=self._run,
            pass_count=sim.step_count, time=sim.time, time_step=sim.time_step,
        )  # fmt: skip

    def _learn(self, now: int) -> None:
        """Find the poses of objects on their bodies, and their appearance, when the model is new or was edited."""
        sim, version = self._sim, self._sim.model_version
        is_another, self._model = self._model is not sim.model, sim.model
        if is_another or self._placed != version:
            self._placed = version
            self._places = Places(sim)
            if is_another or self._places.names != self._frame_names:
                self._frame_names = self._places.names
                self._frames, self._joints = self._pack_frames(), self._pack_joints()
        elapsed = (now - self._zero) / 1e9
        is_due = self._looked != version and elapsed >= self._looks_at + LOOKS_EVERY
        if not is_another and not is_due:
            return
        self._looked, self._looks_at = version, elapsed
        update = scene_update(sim, ROOT, self._writer.messages.new("foxglove.SceneUpdate"))
        looks = update.SerializeToString()
        if looks != self._looks:
            self._looks = looks
            for part in (*update.deletions, *update.entities):
                set_time(part.timestamp, now)
            self._put("/scene", "foxglove.SceneUpdate", now, update.SerializeToString)

    def _pack_frames(self) -> Packed:
        message = self._writer.messages.new("foxglove.FrameTransforms")
        places: list[tuple[Any, str]] = []
        for name in self._frame_names:
            frame = message.transforms.add(parent_frame_id=ROOT, child_frame_id=plain(name))
            places += [(frame.translation, axis) for axis in "xyz"] + [
                (frame.rotation, axis) for axis in "xyzw"
            ]
        return Packed(message, places, [frame.timestamp for frame in message.transforms])

    def _pack_joints(self) -> tuple[list[int], Packed]:
        """Return the handles of all joints that have one number, and their message."""
        sim = self._sim
        joints = [sim.scene.get(handle) for handle in sim.scene.of_kind(ObjectKind.JOINT)]
        joints = [item for item in joints if sim.joints.joint_type(item.handle) != JOINT_TYPES["ball"]]
        message = self._writer.messages.new("foxglove.JointStates")
        places: list[tuple[Any, str]] = []
        for item in joints:
            joint = message.joints.add(name=plain(item.name))
            places += [(joint, "position"), (joint, "velocity")]
        return [item.handle for item in joints], Packed(message, places, [message.timestamp])

    def _tell_signals(self, now: int) -> None:
        """Log the signals that have changed."""
        for kind, schema in _SIGNALS.items():
            present, before = getattr(self._present_signals, kind), self._signals[kind]
            if present == before:
                continue
            for name in [*present, *(before.keys() - present.keys())]:
                value = present.get(name)
                if value == before.get(name):
                    continue
                fields = {} if value is None else {"value": _text(value) if kind == "strings" else value}
                self._send(f"/signals/{name}", f"simx.{schema}", now, is_set=value is not None, **fields)
            self._signals[kind] = dict(present)

    def _tell_messages(self) -> None:
        """Log the new messages of the status bar."""
        bar = self._status_bar
        new, self._told = bar.count - self._told, bar.count
        for message in bar.messages[-new:] if new else ():
            self._tell(INFO, message)

    def _tell(self, level: int, text: str) -> None:
        self._send("/log", "foxglove.Log", self._now, level=level, message=text[:_LONGEST_TEXT], name="simx")


def _text(value: bytes) -> str:
    return value[:_LONGEST_TEXT].decode("utf-8", "replace")
