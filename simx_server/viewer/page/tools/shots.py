"""Save what a browser shows: an image, or a film of it. The file is downloaded by the browser that asked for it."""

from __future__ import annotations

import io
import logging
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from fractions import Fraction
from pathlib import Path

import numpy as np
import viser
from PIL import Image

from simx_server.outputs.packages import OutputError

logger = logging.getLogger(__name__)

FPS = 10
"""Frames a second of a film; a browser that draws slower repeats frames."""

LONGEST = 120.0
"""Seconds after which a film ends automatically."""

_TIMEOUT = 20.0
"""Seconds to wait for a frame; a browser without a graphics card takes its time."""

_SIZE = (1280, 720)
"""Width and height of a film, and of an image at most."""

_RECORD, _END = "Film", "End film"


class Shots:
    """Two buttons. `tell` reports a problem in every browser."""

    def __init__(self, gui: viser.GuiApi, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._image = gui.add_button(
            "Screenshot", icon=viser.Icon.CAMERA, hint="of the 3-D view, as PNG; the browser saves it"
        )
        self._film = gui.add_button(
            _RECORD,
            icon=viser.Icon.VIDEO,
            hint=f"of the 3-D view, as MP4, at most {LONGEST:g} s; press again to end",
        )
        self._ending: threading.Event | None = None
        self._lock = threading.Lock()
        self._image.on_click(lambda event: self._take(event.client))
        self._film.on_click(lambda event: self._start_or_end(event.client))

    def close(self) -> None:
        """End a film that is being made."""
        ending = self._ending
        if ending is not None:
            ending.set()

    # --- on threads of viser's -------------------------------------------------------------------

    def _take(self, client: viser.ClientHandle | None) -> None:
        if client is None:
            return
        try:
            pixels = frame(client)
        except Exception as problem:  # the browser has left, or does not draw
            self._tell(f"the browser made no image: {problem or 'it took too long'}")
            return
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "png")
        client.send_file_download(_name("png"), file.getvalue(), save_immediately=True)

    def _start_or_end(self, client: viser.ClientHandle | None) -> None:
        with self._lock:
            if self._ending is not None:
                self._ending.set()
                return
            if client is None:
                return
            self._ending = ending = threading.Event()
        self._film.label = _END
        try:
            content = film(client, ending)
            client.send_file_download(_name("mp4"), content, save_immediately=True)
        except OutputError as problem:
            self._tell(str(problem))
        except Exception as problem:
            logger.warning("a film of the page could not be made: %r", problem)
            self._tell(f"the browser made no film: {problem or 'it took too long'}")
        finally:
            self._film.label = _RECORD
            with self._lock:
                self._ending = None


def frame(client: viser.ClientHandle) -> np.ndarray:
    """Return what a browser shows, (height, width, 3) of 8 bits. Raises what viser raises."""
    width = min(_SIZE[0], int(client.camera.image_width) or _SIZE[0])
    height = min(_SIZE[1], int(client.camera.image_height) or _SIZE[1])
    pixels = client.camera.get_render(height, width, transport_format="jpeg", timeout=_TIMEOUT)
    return np.ascontiguousarray(pixels[:, :, :3])


def film(client: viser.ClientHandle, ending: threading.Event) -> bytes:
    """Film what a browser shows until the event, or for `LONGEST` seconds; return an MP4 file.

    Raises:
        OutputError: a package is missing, or the film cannot be written.
    """
    from simx_server.outputs.filming.film_file import FilmWriter  # slow, and often not needed

    first = frame(client)
    with tempfile.TemporaryDirectory(prefix="simx-film-") as folder:
        path = Path(folder) / "page.mp4"
        writer = FilmWriter(path, (first.shape[1], first.shape[0]), Fraction(FPS))
        began, number, count = time.monotonic(), 0, 0
        pixels: np.ndarray | None = first
        while pixels is not None:
            made: Future[np.ndarray] = Future()
            made.set_result(pixels)
            writer.put(number, made)
            count = number + 1
            passed = time.monotonic() - began
            is_over = passed > LONGEST or ending.wait(max(0.0, count / FPS - passed))
            pixels = None if is_over else frame(client)
            number = max(count, int((time.monotonic() - began) * FPS))
        writer.end(max(count, int(min(LONGEST, time.monotonic() - began) * FPS)))
        return path.read_bytes()


def _name(suffix: str) -> str:
    return time.strftime(f"simx-%Y%m%d-%H%M%S.{suffix}")
