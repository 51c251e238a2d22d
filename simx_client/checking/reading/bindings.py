"""Recognise a legacy binding, or its constants, by its content: source, byte code or an extension module."""

from __future__ import annotations

import re

FUNCTIONS_AND_CONSTANTS = ("vrep", "sim")
CONSTANTS_ONLY = ("vrepConst", "simConst")
COMPILED = (".pyc", ".pyo", ".so", ".pyd", ".dylib")
"""Endings of compiled modules: byte code of any Python, extension modules of any system."""

# Statements at the left margin, so that a text that only mentions remoteApi.dll does not count. Bytes and
# regular expressions instead of a syntax tree: old bindings need not be valid Python 3, nor UTF-8.
_DEFINES_MODES = re.compile(rb"^simx_opmode_\w+[ \t]*=", re.MULTILINE)
_DEFINES_START = re.compile(rb"^def[ \t]+simxStart\b", re.MULTILINE)
_DECLARES_C_FUNCTIONS = re.compile(rb"^c_\w+[ \t]*=[ \t]*[\w.]*CFUNCTYPE\b", re.MULTILINE)
_NAMES_LIBRARY = re.compile(rb"remoteApi")
_LOADS_LIBRARY = re.compile(rb"\b(CDLL|WinDLL|LoadLibrary)\b")


def is_legacy_binding(source: bytes) -> bool:
    """Return whether this is the source of a ``vrep.py``, ``sim.py`` or one of their constants modules, of
    any age."""
    if _DEFINES_MODES.search(source):
        return True
    if not _DEFINES_START.search(source):
        return False
    if _DECLARES_C_FUNCTIONS.search(source):
        return True
    return bool(_NAMES_LIBRARY.search(source) and _LOADS_LIBRARY.search(source))


_MODE = re.compile(rb"simx_opmode_\w")
_FUNCTION = re.compile(rb"simx[A-Z]\w+")
_C_LIBRARY = re.compile(rb"\bextApi_\w")
_MOST_OF_A_PROGRAM = 60
"""Maximum number of remote functions that a program or its wrapper names; a binding has more than a hundred.
"""


def is_compiled_binding(content: bytes) -> bool:
    """Return whether this is a binding or constants module as byte code, or as an extension module for any
    system.

    Compilers keep names. Constants count if no function is named, which a program that uses them would name;
    functions count together with the code that loads the library, or with the library.
    """
    if b"simxStart" not in content:
        return bool(_MODE.search(content)) and not _FUNCTION.search(content)
    if b"CFUNCTYPE" in content or _C_LIBRARY.search(content):
        return True
    if _NAMES_LIBRARY.search(content) and _LOADS_LIBRARY.search(content):
        return True
    return len(set(_FUNCTION.findall(content))) > _MOST_OF_A_PROGRAM
