"""Start a server in the process of its client: the entry point ``simx.embedding``, which the client looks up.

The settings are those of ``simx-server``, from the same flags and variables. Without ``--port`` or another gateway, no
other process can connect, and nothing is opened on the network.
"""

from __future__ import annotations

import dataclasses
import logging
import os
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from simx_client.errors import ConnectionFailed
from simx_server.errors import CommandError, StartError
from simx_server.gateways.embedded.library import Library
from simx_server.gateways.embedded.transport import EmbeddedTransport
from simx_server.gateways.embedded.turns import Turns
from simx_server.gateways.errors import GatewayError
from simx_server.sensors.opengl.backend import requested_backend
from simx_server.service.loop import ServerLoop
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import SETTINGS, Settings
from simx_server.simulation.simulation import SimulationState
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import ADD_ON

from .cli import make_parser
from .extensions import OPENING_SETTINGS
from .server import attach_outputs, open_world
from .serving import add_viewers, add_watchers, make_service, open_gateways

if TYPE_CHECKING:
    from simx_server.recording import Recorder

logger = logging.getLogger(__name__)


class EmbeddedServer:
    """A simulation and its server loop in this process; see `simx_client.transport.direct.EmbeddedServer`."""

    def __init__(self, settings: Settings) -> None:
        """Open the scene, and the gateways for other processes if the settings name one.

        Raises:
            StartError, CommandError, OSError: with the reason and what to do.
        """
        self.ports: tuple[int, ...] = ()
        """Ports on this host by which other processes can connect."""

        self.view_address = ""
        """Address of the web viewer for a browser on this host; empty without `Settings.view`."""

        self._process = os.getpid()
        self._recorder: Recorder | None = None
        with ExitStack() as stack:
            if settings.record is not None:
                from simx_server.recording import Recorder

                self._recorder = Recorder(settings.record, settings)
                stack.callback(self._recorder.close)
            self.world = open_world(settings, stack, self._recorder and self._recorder.watch)
            attach_outputs(
                self.world, settings, stack, self._recorder.began if self._recorder else time.time_ns()
            )
            self._service = make_service(self.world, settings)
            self._history = add_watchers(self._service, settings, warms_up=False)
            self.loop = ServerLoop(self._service)
            if self._recorder is None:
                self.world.rendering.warm_on_demand()
            has_gateways = any(getattr(settings, name) for name in OPENING_SETTINGS)
            if has_gateways:
                self._open_gateways(settings, stack)
            else:
                self.world.scripts.add_ons[ADD_ON] = Feed(self._service, "embedded", (), self._history)
            self._turns = Turns(self.loop, has_gateways=has_gateways)
            self._stack = stack.pop_all()
        if self._recorder is not None:
            self._recorder.begin(self._service)
        self._turns.begin()
        try:
            if settings.start and self.world.simulation.state is SimulationState.STOPPED:
                for react in self._service.watchers.started:
                    react()
                self.world.simulation.start()
            self._turns.note_change()
        finally:
            self._turns.end()

    def _open_gateways(self, settings: Settings, stack: ExitStack) -> None:
        from simx_server.viewer.launching import browser_address, listen, missing, page

        pages = stack.enter_context(ExitStack())  # ends last, as in a server
        listener = None
        if settings.view is not None:
            if problem := missing():
                raise GatewayError(problem)
            listener = stack.enter_context(listen(settings.view, "--view"))
            self.view_address = browser_address(listener)
        gateways = stack.enter_context(open_gateways(self.world, settings, self._service))
        stack.enter_context(self._service.busy.open())
        self.ports = tuple(gateways.zenoh.ports)
        add_viewers(self.world, self._service, self._history, gateways, has_viewer=listener is not None)
        logger.info("other processes can connect: %s", " ".join(gateways.endpoints))
        if listener is not None:
            pages.enter_context(page(listener, self.ports, settings.temporary_port, settings.operated_arm))

    def connect(self, client: str, name: str, port: int) -> EmbeddedTransport:
        """Return a link for a new client, which has not joined yet.

        Args:
            client: its id.
            name: its name, for logs.
            port: the port that the script asked for.
        """
        return EmbeddedTransport(self.loop, self._turns, client, name, port)

    def library(self, client: str, name: str) -> Library:
        """Return the functions of scripts for the program of this process, as a new client.

        Args:
            client: its id.
            name: its name, for logs.

        Raises:
            LimitReached: all places for clients are taken.
        """
        return Library(self.loop, self._turns, client, name)

    def close(self) -> None:
        """End the simulation and all that belongs to it. Idempotent; does nothing in a fork of its process."""
        if self._process != os.getpid() or self._service.ending.has_come:
            return
        self._turns.begin()
        try:
            self._service.ending.now()
            for react in self._service.watchers.ending:
                react()
            self.world.simulation.stop()
            for react in self._service.watchers.ended:
                react()
        finally:
            self._turns.end()
        self._turns.close()
        self._service.clients.abandon_calls()
        self._stack.close()


def start(arguments: Sequence[str]) -> EmbeddedServer:
    """Start a server in this process.

    Args:
        arguments: those of ``simx-server``.

    Raises:
        ConnectionFailed: the text says what cannot be used, and what is valid.
    """
    try:
        return EmbeddedServer(_settings(arguments))
    except (StartError, CommandError, OSError, ValueError) as error:
        raise ConnectionFailed(f"the embedded simulation cannot start: {error}") from error


def _settings(arguments: Sequence[str]) -> Settings:
    requested_backend()  # refuses an unknown MUJOCO_GL now, before the first image
    parser = make_parser()
    parser.error = _refuse  # pyright: ignore[reportAttributeAccessIssue]
    given = vars(parser.parse_args(list(arguments)))
    for name in given:
        if name not in SETTINGS or SETTINGS[name].needs_process:
            flag = f"--{name.replace('_', '-')}"
            raise SettingError(f"{flag} is for a simx-server in a separate process; leave it out")
    settings = gather(given, os.environ)
    if not any(name in settings.origins for name in OPENING_SETTINGS):
        settings = dataclasses.replace(settings, ports=(0,) if settings.view is not None else ())
    return settings


def _refuse(message: str) -> None:
    raise SettingError(f"{message}; 'simx-server --help' lists the flags")
