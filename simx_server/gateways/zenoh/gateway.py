"""Serve clients over Zenoh. Zenoh's threads only enqueue; the server's threads publish the answers."""

from __future__ import annotations

import logging
import os
import re
import socket
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from simx_client.protocol.codec import CodecError, decode_greeting, encode
from simx_client.protocol.messages import (
    OLDEST_PROTOCOL,
    PROTOCOL_VERSION,
    Status,
    Welcome,
    choose_version,
    no_common_version,
)
from simx_client.protocol.reports import Health, Metrics, encode_report
from simx_client.protocol.zenoh import keys, link
from simx_server import __version__
from simx_server.gateways.errors import GatewayError
from simx_server.gateways.exposure import exposure
from simx_server.gateways.gateway import Gateway, Opening
from simx_server.limits import LimitReached
from simx_server.parts.status_bar import as_log_line
from simx_server.service.calls.work import BatchWork
from simx_server.service.clients.admission.entrance import Entrance
from simx_server.service.monitoring import report
from simx_server.service.monitoring.load import LoadMeter
from simx_server.service.service import Service
from simx_server.simulation.part import Part
from simx_server.simulation.simulation import SimulationState

from .access import has_rules, rules
from .held import HeldBytes
from .link import ZenohLink
from .offers import Offers
from .posting import Care, Postman
from .throttle import Throttle

logger = logging.getLogger(__name__)

FEW_QUESTIONS = 3
"""Waiting queries of one kind above which their senders are slowed down."""

CLOSE_TIMEOUT = 2.0
"""Seconds that Zenoh has to close the session. With a frozen client it needs two, sometimes ten."""

MOST_PRESENT = 10_000
"""Names of clients to remember before they say hello, which they do at once; the oldest are forgotten first. A client
that says hello after 10,000 others have come has to connect again.
"""

_OF_ANOTHER_GATEWAY = object()
"""In place of the secret of a client that has not joined at this gateway; it equals no attachment."""

MOST_SECRET = 64
"""Bytes of a client's secret; ours have 16. A longer one never matches."""


def open_zenoh(opening: Opening) -> ZenohGateway:
    """Open the gateway at the server's ports. Raises GatewayError."""
    settings = opening.settings
    offers = (each for each in opening.opened if isinstance(each, Offers))
    gateway = ZenohGateway(
        opening.service,
        ports=settings.ports,
        listen=settings.listen,
        connect=settings.connect,
        realm=settings.realm,
        config=settings.config,
        multicast_scouting=settings.multicast_scouting,
        offers=next(offers, None),
    )
    return gateway


class ZenohGateway(Gateway, Part):
    """Listens on loopback ports and further endpoints, joins routers, and serves one server loop there."""

    def __init__(
        self,
        service: Service,
        *,
        ports: Sequence[int],
        listen: Sequence[str] = (),
        connect: Sequence[str] = (),
        realm: str | None = None,
        config: Path | None = None,
        multicast_scouting: bool = False,
        offers: Offers | None = None,
    ) -> None:
        """Open the session and declare everything. Physics thread, or before it runs.

        Args:
            ports: on 127.0.0.1; 0 asks the system for a free one.
            listen: further Zenoh endpoints, such as ``tcp/0.0.0.0:19997``.
            connect: Zenoh routers through which clients can also reach the server; it retries those that do not answer.
            realm: the simulator's name in the keys; made from the first port when None.
            config: a Zenoh configuration file; the endpoints above are added to it.
            offers: what clients are offered in their welcome; None for nothing.

        Raises:
            GatewayError: a port is taken, an endpoint or the file is wrong.
        """
        is_plain = config is None and not multicast_scouting
        zenoh = link.import_zenoh(link.SERVER_RUNTIME if is_plain else link.CONFIGURED_SERVER_RUNTIME)
        self._zenoh = zenoh
        self._offers = offers or Offers()
        self._closing: threading.Thread | None = None
        self.ports = tuple(_claim(port) for port in ports)
        self.endpoints = (*[f"tcp/127.0.0.1:{port}" for port in self.ports], *listen)
        self.load = LoadMeter()
        """Needs a call after every simulation step."""

        self._began = time.monotonic()
        if not self.endpoints:
            raise GatewayError("there is nothing to listen on; give a --port or a --listen endpoint")
        host = re.sub(r"[^A-Za-z0-9.-]", "-", socket.gethostname())[:48] or "host"
        # Behind routers there are other hosts, where the same port may be in use.
        owner = host if connect else "simx"
        name = realm or (f"{owner}-{self.ports[0]}" if self.ports else f"simx-{host}")
        try:
            self.realm = keys.check_chunk(name)
        except ValueError as error:
            raise GatewayError(f"--realm: {error}") from None
        self._present: dict[str, None] = {}
        """Clients with a liveliness token, in the order of their arrival."""

        self._secrets: dict[str, bytes | None] = {}
        """The secret that comes with each message of a client that has joined here; None: the client predates secrets.
        Clients of other gateways, whose names a peer may know, are not in it.
        """

        self._presence = threading.Lock()
        """Lock of these two."""

        more: dict[str, Any] = {}
        if connect:
            more |= {**link.TO_ROUTERS, "connect/endpoints": list(connect)}
        # All clients behind a router share its link, so it must not be slowed down.
        self._throttle = Throttle(link.READERS if is_plain and not connect else 0)
        self._care = Care()
        self._session = self._open(config, more, multicast_scouting)
        self._entrance = Entrance(f"zenoh {self.realm}")
        service.clients.places.open(self._entrance.gateway)
        super().__init__(service)
        self._held = HeldBytes(self._session, service.unfinished)
        self._declare()

    def _open(self, config_file: Path | None, more: dict[str, Any], multicast_scouting: bool) -> Any:
        zenoh = self._zenoh
        options: dict[str, Any] = {"mode": "peer", "listen/endpoints": list(self.endpoints), **more}
        defaults = {**link.SERVER, "scouting/multicast/enabled": multicast_scouting}
        if config_file is None:
            config = link.configure(zenoh.Config(), defaults)
        else:
            try:
                config = link.configured_by(zenoh, config_file, defaults)
            except zenoh.ZError as error:
                raise GatewayError(f"{config_file} is no Zenoh configuration: {link.reason(error)}") from None
        if not has_rules(config):
            link.configure(config, {"access_control": rules(self.realm)})
        if warning := exposure(self.endpoints, config):
            logger.warning("%s", warning)
        try:
            return zenoh.open(link.configure(config, options))
        except zenoh.ZError as error:
            raise GatewayError(
                f"cannot listen on {', '.join(self.endpoints)}{_and_connect(more)}: {link.reason(error)}; "
                "an endpoint is PROTOCOL/ADDRESS, as in tcp/0.0.0.0:7447"
            ) from None

    def _declare(self) -> None:
        session, realm = self._session, self.realm
        direct = self._zenoh.handlers.Callback
        asked = keys.hello(realm), keys.status(realm), keys.health(realm), keys.metrics(realm)
        hello, status, health, metrics = (
            self._answering(key, answer)
            for key, answer in zip(
                asked, (self._welcome, self._tell_status, self._tell_health, self._tell_metrics), strict=True
            )
        )
        asks = hello, status, self._at_once_if_busy(health), metrics
        self._answers = {key: Postman(self._care, partial(self._service.queue.suspend, key)) for key in asked}
        # complete=True: a client's query may stop at this server.
        self._queryables = [
            session.declare_queryable(key, direct(ask, indirect=False), complete=True)
            for key, ask in zip(asked, asks, strict=True)
        ]
        self._calls = session.declare_subscriber(keys.call(realm), direct(self._take_in(), indirect=False))
        self._clients = session.liveliness().declare_subscriber(
            keys.client(realm), direct(self._on_client, indirect=False), history=True
        )
        self._token = session.liveliness().declare_token(keys.alive(realm))

    # --- Zenoh's threads -------------------------------------------------------------------------

    def _take_in(self) -> Callable[[Any], None]:
        """Return the callback for a batch of calls. It takes the interpreter from other threads, so it is short."""
        is_from, submit, slow_down = self._is_from, self._service.queue.put, self._throttle.slow_down
        completed = self._held.completed
        begin, to_bytes = len(keys.call(self.realm, "")), self._zenoh.ZBytes.to_bytes

        def read(payload: Any) -> BatchWork:
            return BatchWork(to_bytes(payload))

        def take_in(sample: Any) -> None:
            client, payload = str(sample.key_expr)[begin:], sample.payload
            size = len(payload)
            if is_from(client, sample):
                completed(client, size)
                if submit(client, payload, size, read):
                    return
            slow_down(size)

        return take_in

    def _answering(self, kind: str, answer: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return the callback for a query that the physics thread answers, unless too many wait already."""

        def ask(query: Any) -> None:
            waiting = self._service.queue.ask(kind, partial(answer, query))
            if not waiting:
                query.drop()
            if not waiting or waiting > FEW_QUESTIONS:
                self._throttle.slow_down(0)

        return ask

    def _at_once_if_busy(self, ask: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return a callback that answers at once while the server is busy, as health matters most then."""

        def health(query: Any) -> None:
            if self._service.busy.describe():
                self._tell_health(query)
            else:
                ask(query)

        return health

    def _on_client(self, sample: Any) -> None:
        client = str(sample.key_expr).rpartition("/")[2]
        is_gone = sample.kind == self._zenoh.SampleKind.DELETE
        if len(client) > keys.LONGEST:  # no client can have such a name
            return
        with self._presence:
            if is_gone:
                self._present.pop(client, None)
                has_joined = self._secrets.pop(client, _OF_ANOTHER_GATEWAY) is not _OF_ANOTHER_GATEWAY
            else:
                has_joined = False
                self._present[client] = None
                if len(self._present) > max(MOST_PRESENT, 2 * len(self._service.clients.sessions)):
                    del self._present[
                        next(name for name in self._present if name not in self._service.clients.sessions)
                    ]
        if has_joined:
            self._service.clients.depart(client)

    # --- the physics thread ----------------------------------------------------------------------

    def _is_from(self, client: str, message: Any) -> bool:
        """Return whether a sample or query carries the secret that came with this client's hello at this gateway.

        Names of clients are part of keys that others may subscribe to; attachments of calls are not.
        """
        attached = message.attachment
        secret = self._secrets.get(client, _OF_ANOTHER_GATEWAY)
        return secret == (None if attached is None else attached.to_bytes())

    def _welcome(self, query: Any) -> None:
        version, refusal, client = PROTOCOL_VERSION, "", ""
        if query.payload is not None:
            joined = self._join(query)
            if joined is None:
                query.drop()  # without an answer: it asks again
                return
            version, refusal, client = joined
        offer = "" if refusal else self._offers.offer_to(client)
        scene = self._service.simulation.scene.name
        welcome = Welcome(version, refusal, self.realm, scene, __version__, offer)
        self._answer(query, keys.hello(self.realm), encode(welcome))

    def _join(self, query: Any) -> tuple[int, str, str] | None:
        """Accept the client that says hello with a query.

        Returns:
            The version of the protocol to speak and, if the client is refused, the reason; then the client. None if the
            server could not detect that the client leaves.
        """
        try:
            greeting = decode_greeting(query.payload.to_bytes())
            client = keys.check_chunk(greeting.client)
        except (CodecError, ValueError) as error:
            return PROTOCOL_VERSION, f"the greeting could not be read ({error})", ""
        spoken_there, spoken_here = (greeting.protocol, greeting.newest), (OLDEST_PROTOCOL, PROTOCOL_VERSION)
        version = choose_version(spoken_there, spoken_here)
        if version is None:
            refusal = no_common_version(spoken_there, spoken_here)
            logger.warning("client %s is refused: %s", as_log_line(greeting.name), refusal)
            return PROTOCOL_VERSION, refusal, client
        if client not in self._present or self._service.queue.is_leaving(client):
            return None
        if client in self._service.clients.sessions:
            if not self._is_from(client, query):
                return version, f"another client is called {client}", client
            if self._offers.serves(client):
                self._service.clients.depart(client)  # it has lost that connection, and so its session
                return None
        else:
            self._secrets[client] = (
                None if query.attachment is None else query.attachment.to_bytes()[:MOST_SECRET]
            )
            postman = Postman(self._care, partial(self._service.queue.suspend, client))
            ended = partial(self._secrets.pop, client, None)
            zenoh_link = ZenohLink(self._zenoh, self._session, self.realm, client, postman, ended)
            its_link = self._offers.invite(client, zenoh_link)
            try:
                self._service.clients.join(
                    client, greeting.name, greeting.port, its_link, entrance=self._entrance
                )
            except LimitReached as problem:
                its_link.close()
                return version, str(problem), client
        return version, "", client

    def _tell_status(self, query: Any) -> None:
        simulation, load = self._service.simulation, self.load.load()
        is_running = simulation.state is SimulationState.RUNNING
        status = Status(
            PROTOCOL_VERSION,
            self.realm,
            simulation.scene.name,
            simulation.state.value,
            len(self._service.clients.sessions),
            list(self.ports),
            socket.gethostname(),
            os.getpid(),
            time.monotonic() - self._began,
            load.real_time_factor if is_running else 0.0,
            load.core_share,
            __version__,
        )
        self._answer(query, keys.status(self.realm), encode(status))

    def _tell_health(self, query: Any) -> None:
        self._report(query, keys.health(self.realm), report.health(self._service, self.realm))

    def _tell_metrics(self, query: Any) -> None:
        self._report(query, keys.metrics(self.realm), report.metrics(self._service, self.realm, self.ports))

    def _report(self, query: Any, key: str, said: Health | Metrics) -> None:
        self._answer(query, key, encode_report(said), encoding=self._zenoh.Encoding.APPLICATION_JSON)

    def _answer(self, query: Any, key: str, payload: bytes, **options: Any) -> None:
        """Answer a query without waiting for its sender, which asks again after a loss."""

        def reply() -> None:
            try:
                with query:
                    query.reply(key, payload, **options)
            except self._zenoh.ZError as error:  # who asked has given up, as on a busy machine
                logger.debug("a question about %s was dropped by its sender: %s", key, error)

        self._answers[key].send(reply, len(payload))

    def step_finished(self) -> None:
        self.load.passed(self._service.simulation.time_step)

    def close(self) -> None:
        """Leave the network. Clients notice at once.

        Zenoh waits up to ten seconds for a client that reads nothing any more; the end of the process does not.
        """
        if self._is_open:
            self._end()
        if self._closing is not None:
            self._closing.join(CLOSE_TIMEOUT)
            if self.is_closing:
                logger.warning("a client that takes nothing any more is not waited for")

    @property
    def is_closing(self) -> bool:
        return self._closing is not None and self._closing.is_alive()

    def leave(self) -> None:
        """Close this gateway while the server goes on: its clients leave."""
        with self._presence:
            clients = list(self._secrets)
        self._end(clients)

    def _end(self, clients: Sequence[str] = ()) -> None:
        """Have a thread close the session, after which clients leave."""
        super().close()
        self._held.stop()
        self._service.clients.places.close(self._entrance.gateway)
        self._closing = threading.Thread(
            target=self._close_session, args=(clients,), name="simx-close", daemon=True
        )
        self._closing.start()

    def _close_session(self, clients: Sequence[str]) -> None:
        try:
            self._session.close()
        except self._zenoh.ZError as error:
            logger.warning("a client that takes nothing any more was not waited for: %s", link.reason(error))
        for client in clients:
            self._service.clients.depart(client)


def _and_connect(options: dict[str, Any]) -> str:
    routers = options.get("connect/endpoints")
    return f" and connect to {', '.join(routers)}" if routers else ""


def _claim(port: int) -> int:
    """Check that a loopback port is free, or find a free one for 0.

    Raises:
        GatewayError: taken or not allowed.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        if os.name == "posix":  # on Windows it would let two listen on one port
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
            probe.listen(1)
        except PermissionError:
            raise GatewayError(f"port {port} needs more rights; choose one above 1023 with --port") from None
        except OSError as error:
            raise GatewayError(
                f"port {port} is taken ({error.strerror}), perhaps by another simx-server or a V-REP; "
                f"stop that one, or choose another port with --port N (0 finds a free one)"
            ) from None
        return int(probe.getsockname()[1])
