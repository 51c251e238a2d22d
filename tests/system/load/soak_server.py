"""The server of the soak, and its counts when no client is connected and the first scene is loaded."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import json
import logging
import os
import time
import traceback
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simx_server.app.server import open_world
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.handlers import HANDLERS
from simx_server.scene.trial import helper
from simx_server.service.answers.link import Link
from simx_server.service.calls.work import Work
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.clock import Pacer
from simx_server.service.loop import ServerLoop
from simx_server.service.service import build_service
from simx_server.settings.settings import Settings

SCENE = Path(__file__).parents[2] / "conformance" / "scene.xml"
SPEED = 4.0
DECLARED = ("publisher", "subscriber", "queryable", "querier", "token")
"""Zenoh's words for what a session may declare, as they stand in the keys of its admin space."""
ADMIN_TIMEOUT = 10.0
SETTLING = 1.0
"""Seconds of serving before anything is counted: pictures on their way, links that are being closed."""
FEW = 100
"""As many more instances of a class are no leak: the newest picture of each camera keeps those who asked for it, with
all their streams."""


@dataclass(frozen=True)
class Counts:
    """The quantities that could grow, at rest."""

    seconds: float
    batches: int
    """Of calls, that have arrived."""
    connections: int
    memory_mb: float
    """Resident, with what malloc holds back returned."""
    peak_mb: float
    threads: int
    open_files: int
    children: int
    """Processes: scripts in Python have one each."""
    links: int
    """Of Zenoh, to clients."""
    declarations: int
    """Of Zenoh, of the server's own and of clients that it knows of."""
    sessions: int
    streams: int
    handles: int
    """Objects, collections and what else has a handle."""
    instances: int
    """Of all classes of the server."""
    workspace_files: int


class Crashes(logging.Handler):
    """Every exception that the server did not foresee, once per place; it logs those with a traceback."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.texts: dict[str, None] = {}

    def emit(self, record: logging.LogRecord) -> None:
        if record.exc_info is not None and record.exc_info[1] is not None:
            error = record.exc_info[1]
            where = traceback.extract_tb(error.__traceback__)[-1]
            what = record.getMessage().partition(" of ")[0]
            self.texts[
                f"{what}: {type(error).__name__} in {where.filename}:{where.lineno}: {str(error)[:200]}"
            ] = None


class WatchedGateway(ZenohGateway):
    """A gateway that tells what is declared."""

    def _open(self, config_file: Path | None, more: dict[str, Any], multicast_scouting: bool) -> Any:
        return super()._open(config_file, {**more, "adminspace/enabled": True}, multicast_scouting)

    def _admin(self, key: str) -> list[Any]:
        root = f"@/{self._session.info.zid()}/peer"
        return [r.ok for r in self._session.get(f"{root}{key}", timeout=ADMIN_TIMEOUT) if r.ok is not None]

    def links(self) -> int:
        (status,) = self._admin("")
        return len(json.loads(status.payload.to_string())["sessions"])

    def declared(self) -> list[str]:
        """Kind and key of each declaration."""
        return [
            str(found.key_expr).split("/peer/", 1)[1]
            for kind in DECLARED
            for found in self._admin(f"/{kind}/**")
        ]


class SoakServer:
    """Everything of a server but its process."""

    def __init__(self, stack: ExitStack, workspace: Path) -> None:
        self.workspace, self.scene = workspace, SCENE
        self.parts = open_world(Settings(scene=str(SCENE), workspace=workspace), stack)
        self.simulation = self.parts.simulation
        self.parts.trials.use(helper.start())  # as a server has one from its start
        pacer = Pacer(SPEED)
        self.loop = ServerLoop(build_service(self.parts, HANDLERS, pacer))
        self.parts.parameters.served_by(pacer, lambda: False)
        self.batches = 0
        submit_as = self.loop.service.queue.put

        def counting(client: str, payload: Any, size: int, read: Callable[[Any], Work]) -> bool:
            self.batches += 1
            return submit_as(client, payload, size, read)

        self.loop.service.queue.put = counting  # type: ignore[method-assign]
        self.connections = 0
        join = self.loop.service.clients.join

        def joined(client: str, name: str, port: int, link: Link, *more: Any, **named: Any) -> ClientSession:
            self.connections += 1
            return join(client, name, port, link, *more, **named)

        self.loop.service.clients.join = joined
        self.gateway = WatchedGateway(self.loop.service, ports=[0])
        stack.callback(self.gateway.close)
        self.port = self.gateway.ports[0]
        self.began = time.monotonic()
        self.census: list[Counter[str]] = []
        self.declared: list[list[str]] = []

    def turn(self, seconds: float) -> None:
        self.loop.run(time.monotonic() + seconds)

    def rest(self) -> Counts:
        """Load the first scene, take back what scenes outlive, settle, and count."""
        simulation = self.simulation
        simulation.stop()
        simulation.load(SCENE)
        for clear in ("integer", "float", "string"):
            getattr(self.parts.signals, f"clear_{clear}")("")
        consoles, dialogs = self.parts.user_interface.consoles, self.parts.user_interface.dialogs
        for console in list(consoles):
            consoles.close(console.handle)
        for dialog in list(dialogs):
            dialogs.remove(dialog.handle)
        self.turn(SETTLING)
        gc.collect()
        ctypes.CDLL(None).malloc_trim(0)
        sessions = self.loop.service.clients.sessions.values()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        status = Path("/proc/self/status").read_text()
        tasks = list(Path("/proc/self/task").iterdir())
        self.census.append(_census())
        self.declared.append(self.gateway.declared())
        return Counts(
            round(time.monotonic() - self.began, 1),
            self.batches,
            self.connections,
            round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 1),
            round(int(status.partition("VmHWM:")[2].split()[0]) * 1.024e-3, 1),
            len(tasks),
            len(os.listdir("/proc/self/fd")),
            sum(map(_children, tasks)),
            self.gateway.links(),
            len(self.declared[-1]),
            len(sessions),
            sum(len(session.streams.by_id) for session in sessions),
            len(simulation.scene.objects) + len(self.parts.collections.names()),
            self.census[-1].total(),
            len(list(self.workspace.rglob("*"))),
        )

    def left_behind(self) -> list[str]:
        """Classes of the server with more instances than after the first round, and declarations that are new."""
        first, last = self.census[min(1, len(self.census) - 1)], self.census[-1]
        grown = {name: (first[name], n) for name, n in last.items() if n > first[name] + FEW}
        found = [f"{name}: from {was} to {now} instances" for name, (was, now) in grown.items()]
        new = sorted(set(self.declared[-1]) - set(self.declared[0]))
        return found + [f"{key} is still declared" for key in new[:10]]


def _children(task: Path) -> int:
    """How many processes a thread has started that are still there; none once it has ended."""
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        return len((task / "children").read_text().split())
    return 0


def _census() -> Counter[str]:
    kinds = (type(each) for each in gc.get_objects())
    return Counter(
        f"{kind.__module__}.{kind.__qualname__}"
        for kind in kinds
        if str(kind.__module__).startswith(("simx_server", "simx_client"))
    )
