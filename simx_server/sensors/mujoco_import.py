"""Import mujoco whatever MUJOCO_GL says. Standard library only, so it can run before anything else does.

mujoco 4.0 acts on MUJOCO_GL while it is imported: an unknown value raises RuntimeError, and `osmesa` without
its library raises AttributeError from deep inside PyOpenGL. A server must start all the same, since physics
needs no OpenGL, and say what is wrong with the variable when a picture is wanted (`gl_backend`).
"""

import importlib
import logging
import os
import sys

logger = logging.getLogger(__name__)

_READ_AT_IMPORT = ("MUJOCO_GL", "PYOPENGL_PLATFORM")


def import_mujoco() -> None:
    """Import mujoco as usual; if MUJOCO_GL makes that fail, import it without mujoco's own OpenGL classes.

    The environment is left as it was found. Call it before the first `import mujoco` of the process.

    Raises:
        ImportError: mujoco itself is missing or broken.
    """
    if "mujoco" in sys.modules:
        return
    before = {name: os.environ.get(name) for name in _READ_AT_IMPORT}
    try:
        importlib.import_module("mujoco")
    except Exception as error:
        if not before["MUJOCO_GL"] or isinstance(error, ModuleNotFoundError):
            raise
        logger.debug("mujoco does not import with MUJOCO_GL=%s: %s", before["MUJOCO_GL"], error)
        os.environ["MUJOCO_GL"] = "disable"
        try:
            importlib.import_module("mujoco")
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value
