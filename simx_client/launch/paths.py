"""Translate Windows paths: on POSIX ``"imgTemp\\frame.jpg"`` means imgTemp/frame.jpg.

A path is translated only if it contains a backslash, is relative or below the working folder or the script's
folder (``os.getcwd() + "\\imgTemp"``), and no file of exactly that name exists. Opening a file for writing
creates its folder; nothing else creates folders.

The set of patched functions is small on purpose. Python code that opens files calls ``open`` or one of the
``os`` functions below: ``os.path.exists`` and others, ``shutil``, ``pathlib``, ``glob``, ``np.save``,
``np.load``, PIL. Only libraries that open files in C need separate patches: OpenCV's images and films,
pygame's images.
"""

from __future__ import annotations

import builtins
import functools
import io
import os
import posixpath
import re
from collections.abc import Callable
from types import ModuleType
from typing import Any

_PLAIN_LSTAT = os.lstat  # saved before the patch: the test for a file of exactly that name must not translate
_NOT_RELATIVE = re.compile(r"[/\\]|[A-Za-z]:")

_ONE_PATH = (
    *("stat", "lstat", "access", "open", "listdir", "scandir", "chdir"),
    *("remove", "unlink", "mkdir", "rmdir", "chmod", "utime", "truncate", "readlink"),
)
_TWO_PATHS = ("rename", "replace", "link", "symlink")
_TEXT_ONLY = ("split", "dirname", "basename")  # makedirs and glob split paths with these


class BackslashPaths:
    """Translates paths for one script."""

    def __init__(self, script_folder: str) -> None:
        self._script_folder = script_folder

    def real(self, path: Any, *, writing: bool = False) -> Any:
        """Return the translated path, with its folder created if `writing`; other paths are returned
        unchanged."""
        text = _text(path)
        if "\\" not in text or not self._is_ours(text) or _exists(text):
            return path
        translated = text.replace("\\", "/")
        if writing and (folder := os.path.dirname(translated)):
            os.makedirs(folder, exist_ok=True)
        return translated

    def _is_ours(self, text: str) -> bool:
        if not _NOT_RELATIVE.match(text):
            return True
        try:
            folders = (self._script_folder, os.getcwd())
        except FileNotFoundError:  # the working folder was removed
            folders = (self._script_folder,)
        return any(text.startswith((folder + "/", folder + "\\")) for folder in folders)

    def install(self) -> None:
        """Patch ``open`` and ``os`` in this process."""
        opener = self._wrapped_open(builtins.open)
        builtins.open = opener
        io.open = opener
        for names, count in ((_ONE_PATH, 1), (_TWO_PATHS, 2)):
            for name in names:
                plain = getattr(os, name)
                wrapped = self._wrapped(plain, range(count))
                setattr(os, name, wrapped)
                # shutil and others test whether a function is in these sets
                for supported in (os.supports_dir_fd, os.supports_fd, os.supports_follow_symlinks):
                    if plain in supported:
                        supported.add(wrapped)
        for name in _TEXT_ONLY:
            setattr(posixpath, name, self._wrapped(getattr(posixpath, name), range(1)))

    def patch_cv2(self, cv2: ModuleType) -> None:
        """Patch the functions for images and films of OpenCV."""
        for name in ("imread", "imreadmulti"):
            self._replace(cv2, name, range(1))
        for name in ("imwrite", "imwritemulti"):
            self._replace(cv2, name, range(1), writing=True)
        for name, writing in (("VideoCapture", False), ("VideoWriter", True)):
            if (film := getattr(cv2, name, None)) is not None:
                # in the class itself: OpenCV's classes cannot be subclassed
                self._replace(film, "__init__", range(1, 2), writing=writing)
                self._replace(film, "open", range(1, 2), writing=writing)

    def patch_pygame_image(self, image: ModuleType) -> None:
        """Patch the functions for images of pygame."""
        for name in ("load", "load_basic", "load_extended"):
            self._replace(image, name, range(1))
        for name in ("save", "save_extended"):
            self._replace(image, name, range(1, 2), writing=True)

    def _replace(self, owner: object, name: str, positions: range, *, writing: bool = False) -> None:
        function = getattr(owner, name, None)
        if function is not None and not hasattr(function, "__wrapped__"):
            setattr(owner, name, self._wrapped(function, positions, writing=writing))

    def _wrapped(self, function: Callable[..., Any], positions: range, *, writing: bool = False) -> Any:
        keywords = ("path", "src", "dst", "filename", "file", "target", "top", "p")

        @functools.wraps(function)
        def with_real_paths(*args: Any, **kwargs: Any) -> Any:
            values = list(args)
            for position in positions:
                if position < len(values):
                    values[position] = self.real(values[position], writing=writing)
            for keyword in keywords:
                if keyword in kwargs:
                    kwargs[keyword] = self.real(kwargs[keyword], writing=writing)
            return function(*values, **kwargs)

        return with_real_paths

    def _wrapped_open(self, function: Callable[..., Any]) -> Any:
        @functools.wraps(function)
        def open(file: Any, mode: Any = "r", *args: Any, **kwargs: Any) -> Any:
            writing = isinstance(mode, str) and any(letter in mode for letter in "wax")
            return function(self.real(file, writing=writing), mode, *args, **kwargs)

        return open


def _text(path: Any) -> str:
    """Return the path as text; empty for bytes, file descriptors and other arguments of ``open``."""
    if hasattr(path, "__fspath__"):
        path = path.__fspath__()
    return path if isinstance(path, str) else ""


def _exists(text: str) -> bool:
    try:
        _PLAIN_LSTAT(text)
    except (OSError, ValueError):  # ValueError: a NUL inside
        return False
    return True
