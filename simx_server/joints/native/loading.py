"""Load the compiled module and connect it to the running MuJoCo, or find out why physics steps run in Python.

The module has MuJoCo's structs as they were in the headers it was compiled with. So it is used only with the version
of MuJoCo that these headers belong to. It links no MuJoCo: the functions are those of the library that the
mujoco package has loaded.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import mujoco

from simx_server.compiled import Form, import_compiled, source_hash

VARIABLE = "SIMX_PHYSICS_STEP"
"""Environment variable: ``python`` leaves the compiled module unused, to compare the two forms."""

SOURCE = Path(__file__).with_name("_physics_step.c")

_FUNCTIONS = (
    "mj_step",
    "mj_step1",
    "mj_step2",
    "mj_mulJacVec",
    "mj_solveM",
    "mj_isSparse",
    "mj_kinematics",
    "mj_comPos",
    "mj_camlight",
    "mj_flex",
    "mj_tendon",
    "mj_resetData",
    "mj_stateSize",
    "mj_getState",
    "mj_setState",
    "_mjPRIVATE_setTlsLogHandler",
    "_mjPRIVATE_getGlobalLogHandler",
)
_LIBRARIES = "libmujoco.so.*", "libmujoco.*.dylib", "mujoco.dll"


def compiled_module() -> ModuleType | None:
    """Return the compiled module, `_physics_step.pyi`; None where physics steps run in Python."""
    return form().module


def form() -> Form:
    """Return the form that is used now, and why."""
    if os.environ.get(VARIABLE) == "python":
        return Form(None, f"{VARIABLE} is python")
    return _load()


def crew_form() -> Form:
    """Return the form in which worlds step together in threads: there is none but the compiled one."""
    steps = form()
    return steps if steps.module is None else _load_crew()


@cache
def _load() -> Form:
    def connect(module: ModuleType) -> None:
        module.connect(_addresses(), mujoco.MjModel, mujoco.MjData, mujoco.FatalError)

    return _load_connected(SOURCE, connect)


@cache
def _load_crew() -> Form:
    steps = _load().module

    def connect(module: ModuleType) -> None:
        assert steps is not None
        module.connect(_addresses(), steps.API, steps.PhysicsStep)

    return _load_connected(SOURCE.with_name("_crew.c"), connect)


def _load_connected(source: Path, connect: Callable[[ModuleType], None]) -> Form:
    """Import a module that uses MuJoCo, and connect it.

    Args:
        source: its C file.
        connect: passes the addresses of MuJoCo's functions to the module.
    """
    found = import_compiled(source.stem, __package__)
    if (module := found.module) is None:
        return found
    if mujoco.mj_version() != module.HEADER:
        return Form(
            None, f"the module was compiled for MuJoCo {module.HEADER}, and {mujoco.mj_version()} is running"
        )
    if source.exists() and source_hash(source) != module.SOURCE_HASH:
        return Form(None, "the compiled module is older than its source")
    try:
        connect(module)
    except (OSError, AttributeError, KeyError, StopIteration) as error:
        return Form(None, f"the functions of MuJoCo's library are not found ({error})")
    return Form(module, f"compiled for MuJoCo {mujoco.mj_versionString()}")


def _addresses() -> dict[str, int]:
    """Return the addresses of functions in the library that the mujoco package has loaded."""
    folder = Path(mujoco.__file__).parent
    path = next(found for pattern in _LIBRARIES for found in folder.glob(pattern))
    library = ctypes.CDLL(str(path))  # loaded already, so this is the same one
    found = {name: ctypes.cast(getattr(library, name), ctypes.c_void_p).value for name in _FUNCTIONS}
    return {name: address for name, address in found.items() if address is not None}
