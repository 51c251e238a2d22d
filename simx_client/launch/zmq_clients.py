"""Scripts of CoppeliaSim's ZeroMQ remote API: their client is sent to the script's own server.

Such a client looks for a simulator at port 23000; the private server has a free port instead, so that several scripts
can run beside each other.
"""

from __future__ import annotations

import functools
import importlib
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from simx_client.checking.program import ZMQ_CLIENTS, CannotRead, read_program

from .after_import import AfterImport

PACKAGE, OLD_PACKAGE = ZMQ_CLIENTS
_HERE = ("localhost", "127.0.0.1", "::1")


def uses_zmq(script: Path) -> bool:
    """Return whether a script, or a module of it, imports such a client."""
    try:
        return not read_program(script).imports.keys().isdisjoint(ZMQ_CLIENTS)
    except (CannotRead, RecursionError):
        return False


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

    names = [f"{name}{part}" for name in ZMQ_CLIENTS for part in ("", ".asyncio")]
    AfterImport(dict.fromkeys(names, patch)).install()


class OldName(MetaPathFinder):
    """Finds the client under the name that it had when it came with CoppeliaSim, where it is found nowhere else."""

    def install(self) -> None:
        sys.meta_path.append(self)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname.partition(".")[0] != OLD_PACKAGE or find_spec(PACKAGE) is None:
            return None
        new_name = fullname.replace(OLD_PACKAGE, PACKAGE, 1)
        return spec_from_loader(fullname, _Renamed(new_name), is_package=fullname == OLD_PACKAGE)


class _Renamed(Loader):
    """Gives a module the content of another."""

    def __init__(self, name: str) -> None:
        self._name = name

    def exec_module(self, module: ModuleType) -> None:
        content = vars(importlib.import_module(self._name))
        vars(module).update({name: each for name, each in content.items() if not name.startswith("__")})
