"""A wire that stays connected and swallows what is sent: what a pulled cable or a lost firewall entry does to TCP."""

from __future__ import annotations

import contextlib
import socket

from routers import Wire


class HalfOpenWire(Wire):
    """As a wire; in the directions that are said, bytes are taken and never passed on."""

    def __init__(self, to_port: int) -> None:
        self._to_server = self._to_client = False
        super().__init__(to_port)

    def swallow(self, *, to_server: bool = False, to_client: bool = False) -> None:
        self._to_server, self._to_client = to_server, to_client

    def __enter__(self) -> HalfOpenWire:
        return self

    def _pass_on(self, end: socket.socket) -> None:
        if self._to_server if end.getsockname()[1] == self.port else self._to_client:
            with contextlib.suppress(OSError):
                if end.recv(1 << 16):
                    return
            self._drop_all()
        else:
            super()._pass_on(end)
