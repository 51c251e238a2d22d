"""The Linux libraries that an OpenGL back end needs, and which are missing. Imports neither OpenGL nor mujoco.

Loading finds more than a search: a library also fails if its own libraries are missing. A loaded library stays in
the process, so use a child (`gl_probe`), or a process in which a back end has failed already.
"""

import ctypes
import os
import sys
from collections.abc import Sequence

_LINES = {
    "egl": "apt-get install libegl1 libopengl0 libgl1-mesa-dri, or a graphics card's driver",
    "osmesa": "apt-get install libosmesa6",
    "glfw": "apt-get install libgl1, on a machine with a display",
}
INSTALL_HINT = f"for faster images install OpenGL, on Debian or Ubuntu: {_LINES['egl']}"

_LIBRARIES: dict[str, Sequence[Sequence[str]]] = {
    "egl": (("libEGL.so.1",), ("libOpenGL.so.0", "libGL.so.1")),
    "osmesa": (("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),),
    "glfw": (("libGL.so.1",),),
}
"""Groups of libraries; one of each group is enough."""

_PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libOpenGL.so.0": "libopengl0",
    "libOSMesa.so.8": "libosmesa6",
    "libGL.so.1": "libgl1",
}
"""Package names of Debian and Ubuntu."""


def missing_libraries(name: str) -> str | None:
    """Return the libraries that a back end lacks, in words, with their packages; None when all can be loaded.

    Args:
        name: egl, osmesa, glfw; None is returned for others.
    """
    if sys.platform != "linux":
        return None
    if name == "glfw" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return "there is no display (DISPLAY and WAYLAND_DISPLAY are unset)"
    absent = [group[0] for group in _LIBRARIES.get(name, ()) if not any(map(_can_be_loaded, group))]
    if not absent:
        return None
    packages = " ".join(_PACKAGES[library] for library in absent)
    are, package = ("is", "package") if len(absent) == 1 else ("are", "packages")
    return f"{' and '.join(absent)} {are} missing ({package} {packages})"


def install_advice(name: str) -> str:
    """Return how to install what a back end needs."""
    return f"install {name}'s libraries, on Debian or Ubuntu: {_LINES[name]}" if name in _LINES else ""


def why_it_fails(name: str, error: BaseException) -> str:
    """Return why no context could be made: the missing libraries, else the driver and its message."""
    if missing := missing_libraries(name):
        return missing
    said = f"{type(error).__name__}: {error}"
    if name == "egl" and sys.platform == "linux":
        return f"no OpenGL driver works (package libgl1-mesa-dri, or a graphics card's driver; {said})"
    return said


def _can_be_loaded(library: str) -> bool:
    try:
        ctypes.CDLL(library, mode=ctypes.RTLD_GLOBAL)
    except OSError:
        return False
    return True
