"""Scripts of CoppeliaSim's ZeroMQ remote API: their client is sent to the script's own server.

Such a client looks for a simulator at port 23000; the private server has a free port instead, so that several scripts
can run beside each other.
"""

from __future__ import annotations

import functools
import importlib
import logging
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from simx_client.checking.program import ZMQ_CLIENTS, CannotRead, read_program

from .after_import import AfterImport, found_by_others

logger = logging.getLogger(__name__)

PACKAGE, OLD_PACKAGE = ZMQ_CLIENTS
_PARTS = ("", ".asyncio")
"""The package and its modules, behind its name."""

_HERE = ("localhost", "127.0.0.1", "::1")


def uses_zmq(script: Path) -> bool:
    """Return whether a script, or a module of it, imports such a client, or carries one in a package."""
    try:
        program = read_program(script)
    except (CannotRead, RecursionError):
        return False
    if not program.imports.keys().isdisjoint(ZMQ_CLIENTS):
        return True
    return any(_is_first_version(source.path) for source in program.sources)


def send_clients_to(port: int) -> None:
    """Connect the clients that the script makes for this machine to a port of the script's own server."""

    def patch(module: Any) -> None:
        client = module.RemoteAPIClient
        original = client.__init__

        @functools.wraps(original)
        def connect(self: Any, host: str = "localhost", *others: Any, **options: Any) -> None:
            if host in _HERE:
                others, options = (port, *others[1:]), {**options}
                options.pop("port", None)
            original(self, host, *others, **options)

        client.__init__ = connect

    names = [f"{name}{part}" for name in ZMQ_CLIENTS for part in _PARTS]
    AfterImport(dict.fromkeys(names, patch)).install()


class OldName(MetaPathFinder):
    """Finds the client under the name that it had when it came with CoppeliaSim.

    It is found where no other module has this name, and in place of a copy of its first version, which programs carry
    and which speaks another protocol.
    """

    def install(self) -> None:
        sys.meta_path.insert(0, self)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        before, _, part = fullname.partition(OLD_PACKAGE)
        if (before and not before.endswith(".")) or part not in _PARTS or OLD_PACKAGE not in fullname:
            return None
        found = found_by_others(self, fullname, path, target)
        is_old = found is not None and _is_first_version(Path(found.origin or ""))
        if (found is not None and not is_old) or (found is None and before) or find_spec(PACKAGE) is None:
            return None
        if found is not None:
            logger.info("%s replaces %s, its first version", PACKAGE, found.origin)
        return spec_from_loader(fullname, _Renamed(f"{PACKAGE}{part}"), is_package=not part)


def _is_first_version(file: Path) -> bool:
    """Return whether a module is a copy of the first version: a client without the messages of the second."""
    try:
        content = file.read_bytes()
    except OSError:
        return False
    return (
        b"class RemoteAPIClient" in content
        and b"zmqRemoteApi.info" in content
        and b"_*executed*_" not in content
    )


class _Renamed(Loader):
    """Gives a module the content of another."""

    def __init__(self, name: str) -> None:
        self._name = name

    def exec_module(self, module: ModuleType) -> None:
        content = vars(importlib.import_module(self._name))
        vars(module).update({name: each for name, each in content.items() if not name.startswith("__")})
