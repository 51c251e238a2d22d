"""Values that the launcher, the process of a script and the server share."""

from __future__ import annotations

MEMORY_LIMIT = 512 << 20
"""Bytes of address space; numpy alone takes 200 MiB of it."""

OPEN_FILES = 64
"""At the same time."""

OPEN_FILES_OF_PROGRAM = 256
"""The same for a whole program, which loads large libraries."""

NOT_CONFINED = 78
"""Exit code of the launcher when it cannot build the walls; standard error has the reason."""

NATIVE_MODULES = frozenset(
    (
        "ctypes", "_ctypes", "_ctypes_test", "_cffi_backend", "_interpreters", "_xxsubinterpreters", "_testcapi",
        "_testinternalcapi", "_testlimitedcapi",
    )
)  # fmt: skip
"""Modules with which a script calls native functions of its choice."""
