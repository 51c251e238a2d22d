"""Show an environment: as images of a camera, or in the web viewer at real time."""

from __future__ import annotations

import os
import sys
import time
import webbrowser
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from simx_client.client.servers import Servers
from simx_client.protocol import constants as c

from .observations import Reading, find_reading
from .quantities.lookup import Objects
from .quantities.names import WORLD, Subject, read_name
from .quantities.readable import READABLE

MODES = ("rgb_array", "human")
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
"""Variables one of which is set where Linux has a screen."""


def check_mode(mode: str | None, modes: Sequence[str]) -> None:
    """Raise ValueError for a render mode that does not exist here."""
    if mode is not None and mode not in modes:
        raise ValueError(f"render_mode must be {' or '.join(map(repr, modes))} or None, not {mode!r}")


class Film:
    """Images of one camera of each simulation."""

    def __init__(self, servers: Servers, camera: str | None) -> None:
        """Find the camera.

        Args:
            camera: name of a vision sensor; None: the first one of the scene.

        Raises:
            ValueError: the scene has no vision sensor, or the object is something else.
            CallsFailed: no object has this name.
        """
        self._servers = servers
        if camera is not None:
            text = f"{camera}.rgb"
            self._reading = find_reading(text, Objects(servers, [read_name(text)]))
            return
        found = servers.each(lambda calls, _: calls.simxGetObjects(c.sim_object_visionsensor_type))
        if not all(sensors.value for sensors in found):
            raise ValueError(
                "the scene has no vision sensor, which render_mode='rgb_array' needs; add a <camera> to its file, "
                "or use render_mode='human'"
            )
        rgb = next(each for each in READABLE if each.attribute == "rgb")
        subjects = [Subject("", sensors.value[0], WORLD) for sensors in found]
        self._reading = Reading(read_name("CAMERA.rgb"), rgb, subjects)

    def images(self) -> list[NDArray[np.uint8]]:
        """Return an image of each simulation: height × width × 3, top row first."""
        reading = self._reading
        answers = self._servers.each(lambda calls, place: reading.entry.note(calls, reading.subjects[place]))
        return [reading.value(answer) for answer in answers]


class RealTime:
    """Delays steps until they are due at real time."""

    def __init__(self, seconds: float) -> None:
        """Start the clock.

        Args:
            seconds: duration of a step.
        """
        self._seconds = seconds
        self.restart()

    def restart(self) -> None:
        """Start again, at the start of an episode."""
        self._due = time.monotonic()

    def wait(self) -> None:
        """Wait until the next step is due; a late step delays the following ones."""
        self._due = max(self._due + self._seconds, time.monotonic())
        time.sleep(max(0.0, self._due - time.monotonic()))


def open_browser(address: str) -> None:
    """Open the web viewer in a browser where a screen exists; the viewer prints its address in any case."""
    if os.name == "nt" or sys.platform == "darwin" or any(os.environ.get(name) for name in SCREENS):
        webbrowser.open(address)
