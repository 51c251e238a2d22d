"""Windows with SDL, by pygame's interface, which has several windows and a renderer for each."""

from __future__ import annotations

import os
from typing import Any

from simx_client.protocol.cli.installing import extra_line

from .backend import ALT, CONTROL, LEFT, MIDDLE, RIGHT, SHIFT, Backend, Listener, NoBackend

_WITH_WINDOWS = ("x11", "wayland", "windows", "cocoa")
"""SDL's drivers that open windows."""

_BUTTONS = {1: LEFT, 2: MIDDLE, 3: RIGHT}
_UNICODE = 0x01000000
"""Offset of a code point above Latin-1 in an X keysym."""

_KEYSYMS = {
    "RETURN": 0xFF0D, "ESCAPE": 0xFF1B, "BACKSPACE": 0xFF08, "TAB": 0xFF09, "DELETE": 0xFFFF, "INSERT": 0xFF63,
    "HOME": 0xFF50, "LEFT": 0xFF51, "UP": 0xFF52, "RIGHT": 0xFF53, "DOWN": 0xFF54, "PAGEUP": 0xFF55,
    "PAGEDOWN": 0xFF56, "END": 0xFF57, "PAUSE": 0xFF13, "PRINTSCREEN": 0xFF61, "MENU": 0xFF67, "KP_ENTER": 0xFF8D,
    **{f"F{number}": 0xFFBD + number for number in range(1, 16)},
}  # fmt: skip
"""pygame's K_... to X keysyms. Source: X11's keysymdef.h."""


def open_sdl() -> Backend:
    """Open SDL. Raises NoBackend."""
    os.environ["PYGAME_HIDE_SUPPORT_PROMPT"] = "1"
    os.environ["SDL_VIDEO_X11_WMCLASS"] = "simx"
    # A script's choice of a driver without windows is for its own pygame.
    if os.environ.get("SDL_VIDEODRIVER") in ("dummy", "offscreen"):
        del os.environ["SDL_VIDEODRIVER"]
    try:
        import pygame
        from pygame._sdl2 import video
    except ImportError:
        raise NoBackend(f"pygame is not installed ({extra_line('demo')})") from None
    try:
        pygame.display.init()
    except pygame.error as error:
        raise NoBackend(f"pygame cannot open the display: {error}") from None
    if (
        driver := pygame.display.get_driver()
    ) not in _WITH_WINDOWS:  # SDL falls back to any driver, such as one without a screen
        raise NoBackend(f"pygame finds no window system (SDL's driver is '{driver}')")
    pygame.key.set_repeat(400, 30)
    return _Sdl(pygame, video)


class _Sdl:
    name = "pygame"

    def __init__(self, pygame: Any, video: Any) -> None:
        self._pygame, self._video = pygame, video
        self._listeners: dict[int, tuple[Any, Listener]] = {}
        """Window and listener, by SDL's number of the window."""

        self._keysyms = {getattr(pygame, f"K_{name}"): keysym for name, keysym in _KEYSYMS.items()}
        self._mouse = (0, 0)
        self._held = 0
        """Modifiers as of the newest event: SDL's present state may be later than the event at hand."""

        self._typed = ""

    def open(self, title: str, width: int, height: int, listener: Listener) -> _Pane:
        window = self._video.Window(title, size=(width, height), resizable=True)
        self._listeners[window.id] = window, listener
        return _Pane(self, self._pygame, self._video, window)

    def gone(self, number: int) -> None:
        self._listeners.pop(number, None)

    def pump(self) -> None:
        for event in self._pygame.event.get():
            found = getattr(event, "window", None)
            listener = self._listeners.get(found.id) if found is not None else None
            if listener is not None:
                self._deliver(event, *listener)

    def _deliver(self, event: Any, window: Any, listener: Listener) -> None:
        pygame = self._pygame
        kind = event.type
        if kind in (pygame.KEYDOWN, pygame.KEYUP, pygame.TEXTINPUT):
            self._deliver_key(event, listener)
        elif kind in (pygame.MOUSEMOTION, pygame.MOUSEBUTTONDOWN, pygame.MOUSEBUTTONUP, pygame.MOUSEWHEEL):
            self._deliver_mouse(event, listener)
        elif kind == pygame.WINDOWCLOSE:
            listener.on_close()
        elif kind in (pygame.WINDOWMOVED, pygame.WINDOWSIZECHANGED, pygame.WINDOWEXPOSED):
            (x, y), (width, height) = window.position, window.size
            listener.on_place(x, y, width, height)
            if kind == pygame.WINDOWEXPOSED:
                listener.on_exposed()

    def _deliver_key(self, event: Any, listener: Listener) -> None:
        if event.type == self._pygame.TEXTINPUT:
            if event.text != self._typed:  # composed of several keys
                for letter in event.text:
                    listener.on_key(_keysym_of(ord(letter)))
            return
        self._held = event.mod
        if event.type == self._pygame.KEYDOWN:
            self._typed = event.unicode
            listener.on_key(self._keysym(event))

    def _deliver_mouse(self, event: Any, listener: Listener) -> None:
        if event.type == self._pygame.MOUSEWHEEL:
            x, y = self._mouse
            for steps, is_horizontal in ((event.y, False), (event.x, True)):
                if steps:
                    listener.on_wheel(steps, is_horizontal, x, y, self._modifiers())
            return
        self._mouse = x, y = event.pos
        if event.type == self._pygame.MOUSEMOTION:
            listener.on_motion(x, y, self._modifiers())
        elif event.button in _BUTTONS:
            is_down = event.type == self._pygame.MOUSEBUTTONDOWN
            listener.on_button(_BUTTONS[event.button], is_down, x, y, self._modifiers())

    def _keysym(self, event: Any) -> int:
        if event.key in self._keysyms:
            return self._keysyms[event.key]
        if event.unicode and event.unicode.isprintable():
            return _keysym_of(ord(event.unicode[0]))
        if 0 < event.key < 0x110000 and chr(event.key).isprintable():
            return _keysym_of(event.key)  # Control suppresses the text
        return 0

    def _modifiers(self) -> int:
        pygame, held = self._pygame, self._held
        return (
            (SHIFT if held & pygame.KMOD_SHIFT else 0)
            | (CONTROL if held & pygame.KMOD_CTRL else 0)
            | (ALT if held & pygame.KMOD_ALT else 0)
        )


def _keysym_of(code: int) -> int:
    return code if code < 0x100 else _UNICODE | code


class _Pane:
    def __init__(self, owner: _Sdl, pygame: Any, video: Any, window: Any) -> None:
        self._owner, self._pygame, self._video, self._window = owner, pygame, video, window
        # In software: only one image is drawn, and this renderer is always available.
        self._renderer = video.Renderer(window, accelerated=0)

    def draw(self, rgb: Any) -> None:
        height, width = rgb.shape[:2]
        rgb_image = self._pygame.image.frombuffer(rgb.tobytes(), (width, height), "RGB")
        texture = self._video.Texture.from_surface(self._renderer, rgb_image)
        self._renderer.clear()
        texture.draw(dstrect=(0, 0, width, height))
        self._renderer.present()

    def set_title(self, title: str) -> None:
        self._window.title = title

    def set_size(self, width: int, height: int) -> None:
        self._window.size = width, height

    def set_resizable(self, is_resizable: bool) -> None:
        self._window.resizable = is_resizable

    def set_full(self, is_full: bool) -> None:
        if is_full:
            self._window.set_fullscreen(True)
        else:
            self._window.set_windowed()

    def move(self, x: int, y: int) -> None:
        self._window.position = x, y

    def close(self) -> None:
        self._owner.gone(self._window.id)
        self._window.destroy()
