"""Keep the windows that scripts show with ``cv2.imshow`` without a display, for the web viewer.

This is an add-on, as the feed is. The format is in `simx_client.protocol.add_ons.windows`. All its content comes from
outside, so every value is checked and bounded. After a time without calls, a script counts as gone, and its windows
are removed.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import field
from typing import Any

import msgpack

from simx_client.protocol.add_ons import windows as w
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.parts.add_ons import Functions, Results

KEPT = 5.0
"""Seconds without a call after which a script, or a viewer, has gone."""

MOST_OWNERS, MOST_WINDOWS, MOST_TRACKBARS = 16, 16, 32
MOST_HELD = 16 << 20
"""Bytes of all images together."""

MOST_SENT = 4 << 20
"""Bytes of images after which an answer to a viewer has no further ones; its next call brings them."""

MOST_LETTERS = 200
MOST_EVENTS = 256
"""Keys and other events that wait for a script; the oldest are dropped first."""

_JPEG = b"\xff\xd8\xff"
_INT32 = range(-(1 << 31), 1 << 31)

_Told = None | bool | int | float | str | bytes | list[Any] | dict[Any, Any]
"""A value of a MessagePack message."""


@dataclass
class Shown:
    """A window."""

    title: str
    text: str
    trackbars: list[list[Any]]
    image: bytes = b""
    version: int = 0


@dataclass
class Owner:
    """A script."""

    windows: dict[int, Shown] = field(default_factory=dict[int, Shown])
    events: deque[list[Any]] = field(default_factory=lambda: deque(maxlen=MOST_EVENTS))
    heard: float = 0.0


class Windows:
    """The add-on. Physics thread.

    Args:
        has_viewer: this server starts one, which may not have called yet.
        clock: seconds.
    """

    def __init__(self, *, has_viewer: bool = False, clock: Callable[[], float] = time.monotonic) -> None:
        self._has_viewer, self._clock = has_viewer, clock
        self._owners: dict[str, Owner] = {}
        self._watched = float("-inf")
        self._versions = 0
        self._functions = Functions[Callable[[dict[str, Any]], Any]](
            w.ADD_ON,
            {
                w.EXCHANGE: (0, 0, self._exchange),
                w.SHOWN: (0, 0, self._shown),
                w.ACT: (0, 0, self._act),
            },
        )

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results:
        """Call a function of the add-on. Raises CommandError: unknown function, or a buffer that cannot be used."""
        act = self._functions.find(function, ints, floats)
        try:
            told: _Told = msgpack.unpackb(buffer, strict_map_key=False)
        except Exception as error:  # msgpack raises many kinds, ValueError and StackError among them
            raise CommandError(f"{function} takes a map of MessagePack: {error}") from None
        if not isinstance(told, dict):
            raise CommandError(f"{function} takes a map of MessagePack, not {type(told).__name__}")
        self._forget_the_gone()
        return [], [], [], msgpack.packb(act(told))

    def _forget_the_gone(self) -> None:
        now = self._clock()
        self._owners = {name: each for name, each in self._owners.items() if now - each.heard < KEPT}

    # --- the script ------------------------------------------------------------------------------

    def _exchange(self, told: dict[str, Any]) -> dict[str, Any]:
        name = _text(told.get(w.OWNER), w.OWNER)
        windows: _Told = told.get(w.WINDOWS)
        if not isinstance(windows, list) or len(windows) > MOST_WINDOWS:
            raise CommandError(f"{w.WINDOWS} must be a list of at most {MOST_WINDOWS}")
        checked = [_checked(each) for each in windows]
        if not checked and name not in self._owners:
            return {w.IS_WATCHED: self._is_watched, w.EVENTS: []}
        if name not in self._owners and len(self._owners) >= MOST_OWNERS:
            raise CommandError(f"{MOST_OWNERS} scripts show windows already; try again when one has ended")
        owner = self._owners.get(name) or Owner()
        shown = dict(checked)
        for number, window in shown.items():
            if not window.image and (known := owner.windows.get(number)) is not None:
                window.image, window.version = known.image, known.version
        others = [each for other, each in self._owners.items() if other != name]
        held = [window for each in others for window in each.windows.values()]
        if sum(len(window.image) for window in (*held, *shown.values())) > MOST_HELD:
            raise CommandError(
                f"all windows together hold at most {MOST_HELD} bytes; show fewer or smaller images"
            )
        for window in shown.values():
            if window.image and not window.version:
                self._versions += 1
                window.version = self._versions
        owner.heard, owner.windows = self._clock(), shown
        self._owners[name] = owner
        events = list(owner.events)
        owner.events.clear()
        if not checked:
            del self._owners[name]
        return {w.IS_WATCHED: self._is_watched, w.EVENTS: events}

    @property
    def _is_watched(self) -> bool:
        return self._has_viewer or self._clock() - self._watched < KEPT

    # --- a viewer --------------------------------------------------------------------------------

    def _shown(self, told: dict[str, Any]) -> dict[str, Any]:
        self._watched = self._clock()
        given: _Told = told.get(w.KNOWN)
        known: dict[Any, Any] = given if isinstance(given, dict) else {}
        left = MOST_SENT
        windows: list[dict[str, Any]] = []
        for name, owner in self._owners.items():
            for number, window in owner.windows.items():
                there = known.get(f"{name}/{number}")
                image = window.image if there != window.version and left > 0 else None
                left -= len(image or b"")
                windows.append(
                    {
                        w.OWNER: name,
                        w.NUMBER: number,
                        w.TITLE: window.title,
                        w.TEXT: window.text,
                        w.TRACKBARS: window.trackbars,
                        # The old version is sent without the image, so that the viewer asks again.
                        w.VERSION: window.version if image is not None or there == window.version else 0,
                        w.IMAGE: image,
                    }
                )
        return {w.WINDOWS: windows}

    def _act(self, told: dict[str, Any]) -> None:
        name = _text(told.get(w.OWNER), w.OWNER)
        owner = self._owners.get(name)
        if owner is None:
            raise CommandError("the script that showed this window has gone")
        owner.events.append(_event(told.get(w.EVENT)))


def _checked(told: _Told) -> tuple[int, Shown]:
    if not isinstance(told, dict):
        raise CommandError("a window must be a map")
    bars: _Told = told.get(w.TRACKBARS)
    if not isinstance(bars, list) or len(bars) > MOST_TRACKBARS:
        raise CommandError(f"{w.TRACKBARS} must be a list of at most {MOST_TRACKBARS}")
    image: _Told = told.get(w.IMAGE)
    if image is not None and not (
        isinstance(image, bytes) and image.startswith(_JPEG) and len(image) <= w.LARGEST_IMAGE
    ):
        raise CommandError(f"{w.IMAGE} must be a JPEG of at most {w.LARGEST_IMAGE} bytes, or nothing")
    return _int(told.get(w.NUMBER), w.NUMBER), Shown(
        _text(told.get(w.TITLE), w.TITLE),
        _text(told.get(w.TEXT), w.TEXT),
        [_trackbar(each) for each in bars],
        image or b"",
    )


def _trackbar(told: _Told) -> list[Any]:
    if not isinstance(told, list) or len(told) != 4:
        raise CommandError("a trackbar must be a list of label, value, minimum and maximum")
    label, *numbers = told
    value, minimum, maximum = (_int(each, "a trackbar's number") for each in numbers)
    if not minimum <= maximum:
        raise CommandError(f"a trackbar's minimum must not be above its maximum: {minimum}, {maximum}")
    return [_text(label, "a trackbar's label"), min(max(value, minimum), maximum), minimum, maximum]


def _event(told: _Told) -> list[Any]:
    kinds: dict[str, tuple[Callable[[Any, str], Any], ...]] = {
        w.KEY: (_int,),
        w.DRAGGED: (_int, _text, _int),
        w.CLOSED: (_int,),
    }
    if (
        not isinstance(told, list)
        or not told
        or not isinstance(told[0], str)
        or len(told) != 1 + len(kinds.get(told[0], ()))
        or told[0] not in kinds
    ):
        raise CommandError(f"an event must be a list that begins with one of {', '.join(kinds)}")
    return [told[0], *(check(each, told[0]) for check, each in zip(kinds[told[0]], told[1:], strict=True))]


def _int(value: Any, what: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value not in _INT32:
        raise CommandError(f"{what} must be an integer of 32 bits")
    return value


def _text(value: Any, what: str) -> str:
    if not isinstance(value, str):
        raise CommandError(f"{what} must be a text")
    return value[:MOST_LETTERS]
