"""One line about an exception that a newer library caused, where nothing can be restored."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from simx_client.protocol.cli.installing import ZMQ_CLIENT, line, pyrep_line
from simx_client.protocol.files import OPENED_SUFFIXES

_OTHERS = (".c", ".cpp", ".cc", ".cxx", ".h", ".m", ".java", ".jar", ".class")
"""Endings of programs in other languages that use V-REP's own library."""

_NUMPY_1 = (
    "or install 'numpy<2' and 'opencv-python-headless<4.12' into a Python environment of the script's own"
)

_WITH_PYREP = "simx-run --pyrep SCRIPT, and simx stands for CoppeliaSim (docs/pyrep.md)"

_HINTS: tuple[tuple[type[BaseException], str, str], ...] = (
    (
        OverflowError,
        r"Python integer -?\d+ out of bounds for u?int\d+",
        f"NumPy 2 refuses numbers that do not fit, NumPy 1 wrapped them round: convert with "
        f"np.asarray(x, dtype=int).astype(np.uint8), {_NUMPY_1}",
    ),
    (
        TypeError,
        r"only 0-dimensional arrays can be converted",
        "NumPy 2.4 no longer takes an array of one element for a number: leave out --plain and --no-numpy-aliases, "
        f"write x.item(), or {line(['numpy<2.4'])}",
    ),
    (
        ValueError,
        r"setting an array element with a sequence",
        "NumPy 1.24 and later makes no array of parts that differ in length; make them equal, or write "
        "np.array(parts, dtype=object)",
    ),
    (
        ValueError,
        r"Object arrays cannot be loaded when allow_pickle=False",
        "NumPy 1.16.3 and later loads Python objects only on request: np.load(file, allow_pickle=True), for files "
        "that you trust",
    ),
    (
        ModuleNotFoundError,
        r"No module named '(coppeliasim_zmqremoteapi_client|zmqRemoteApi)'",
        f"the client of CoppeliaSim's ZeroMQ remote API is a package: {line([ZMQ_CLIENT])}",
    ),
    *(
        (
            ModuleNotFoundError,
            rf"No module named '{name}'",
            f"{title} is a package: {pyrep_line(name)}; run its programs with {_WITH_PYREP}",
        )
        for name, title in (("pyrep", "PyRep"), ("rlbench", "RLBench"))
    ),
    (
        ImportError,
        r"\bpyrep\.backend\._sim_cffi\b|\b_sim_cffi\.\S*(?:so|pyd|dylib)\b|\blibcoppeliaSim\b",
        f"this is a program of PyRep: run it with {_WITH_PYREP}",
    ),
    (
        Exception,
        r"^COPPELIASIM_ROOT (?:not defined|was not a correct path)",
        f"this is a program of PyRep: name the folder of CoppeliaSim, or run it with {_WITH_PYREP}",
    ),
)


def no_script(name: str | None) -> str | None:
    """Return what to write in place of a name that is missing or that is not a Python script's; None for a script."""
    if not name:
        return "name the Python script to run: simx-run robotControl.py; simx-run --help lists the flags"
    suffix = Path(name).suffix.lower()
    if suffix in OPENED_SUFFIXES:
        return f"{name} is a scene; name a script too: simx-run --server {name} SCRIPT, or open it: simx-server {name}"
    if suffix == ".lua":
        return f"{name} is Lua; scripts in Lua run in the server, as scripts of a scene: docs/scripts.md"
    if suffix in _OTHERS:
        return (
            f"{name} is no Python script; programs in C, C++, MATLAB and Java connect with V-REP's own library: "
            "simx-server --legacy-port 19997, docs/legacy-port.md"
        )
    return None


def misplaced_flags(arguments: Sequence[str], flags: Collection[str], source: bytes) -> Iterator[str]:
    """Yield flags of the launcher behind the script's name that the script itself does not seem to know."""
    for argument in arguments:
        flag = argument.partition("=")[0]
        if flag.startswith("--") and flag in flags and flag.removeprefix("--").encode() not in source:
            yield flag


def hint(error: BaseException) -> str | None:
    """Return what to install or to write; None for an exception of another kind."""
    text = str(error)
    for kind, pattern, sentence in _HINTS:
        if isinstance(error, kind) and re.search(pattern, text):
            return sentence
    return None
