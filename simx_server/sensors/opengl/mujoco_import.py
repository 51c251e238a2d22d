"""Import mujoco without its own OpenGL classes. Standard library only, so it can run before any other import.

mujoco 4.0 reads MUJOCO_GL while it is imported: an unknown value raises RuntimeError, and `osmesa` without its
library raises AttributeError from deep inside PyOpenGL. A server must start all the same, since physics needs no
OpenGL, and report the wrong variable when an image is requested (`gl_backend`). The classes are not used here, and
loading GLFW for them takes a fifteenth of a server's start.
"""

import importlib
import os
import sys

_READ_AT_IMPORT = ("MUJOCO_GL", "PYOPENGL_PLATFORM")


def import_mujoco() -> None:
    """Import mujoco whatever the value of MUJOCO_GL; the environment is restored afterwards.

    Call it before the first `import mujoco` of the process.

    Raises:
        ImportError: mujoco itself is missing or broken.
    """
    if "mujoco" in sys.modules:
        return
    before = {name: os.environ.get(name) for name in _READ_AT_IMPORT}
    os.environ["MUJOCO_GL"] = "disable"
    try:
        importlib.import_module("mujoco")
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
