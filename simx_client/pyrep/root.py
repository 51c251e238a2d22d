"""A folder that PyRep's installation takes for that of the simulator: it builds against it, and links nothing.

PyRep compiles a module against the library `libcoppeliaSim.so`. A text that the linker takes for an empty script is
enough: the compiled module is never loaded, since `finder.py` comes before it.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

_LIBRARY = "libcoppeliaSim.so"
_EMPTY_SCRIPT = "/* An empty linker script: simx_client.pyrep stands for this library. */\n"


def root_folder() -> Path:
    """Return the folder, and make it if it is missing. Raises OSError."""
    root = _cache() / "simx" / "pyrep-root"
    try:
        return _made(root)
    except OSError:  # a home that cannot be written to
        return _made(Path(tempfile.gettempdir()) / f"simx-pyrep-root-{_user()}")


def _made(root: Path) -> Path:
    system = root / "system"
    system.mkdir(parents=True, exist_ok=True)
    library = root / _LIBRARY
    if not library.exists():
        library.write_text(_EMPTY_SCRIPT, encoding="ascii")
    return root


def _cache() -> Path:
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
