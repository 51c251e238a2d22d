"""The parts between a world and its clients: server loop and gateways, of servers and of embedded servers."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from simx_client.protocol.add_ons.windows import ADD_ON as WINDOWS
from simx_server.gateways.descriptors import DescriptorWatch
from simx_server.gateways.gateway import Entry, Gateway, Opening
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.handlers import HANDLERS
from simx_server.history import History
from simx_server.service.clock import Pacer
from simx_server.service.server_loop import ServerLoop
from simx_server.settings.settings import Settings
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import ADD_ON
from simx_server.viewer.windows import Windows
from simx_server.world.world import World

from .extensions import GATEWAYS


@dataclass(frozen=True, slots=True)
class Gateways:
    """The open gateways of a server."""

    zenoh: ZenohGateway
    """That of this project's clients, which every server has."""

    all: Sequence[Gateway]

    @property
    def endpoints(self) -> list[str]:
        """Return where clients reach the server, of all gateways."""
        return [endpoint for gateway in self.all for endpoint in gateway.endpoints]


def make_loop(world: World, settings: Settings) -> ServerLoop:
    """Return the server loop of a world, not running yet."""
    pacer, parameters = Pacer(settings.speed), world.parameters
    starting_port = settings.temporary_port if settings.auto_start else None
    loop = ServerLoop(world, HANDLERS, pacer, starting_port=starting_port)
    loop.metrics.images = world.rendering.times
    loop.watches.append(world.rendering.watch)
    parameters.pace = pacer
    parameters.is_waiting_for_trigger = lambda: loop.is_waiting_for_trigger
    parameters.end = loop.ending.when_left
    loop.history = History(loop, settings.history)
    return loop


@contextmanager
def open_gateways(
    world: World, settings: Settings, loop: ServerLoop, entries: Sequence[Entry] = GATEWAYS
) -> Generator[Gateways]:
    """Open the gateways within the block; then end the clients' calls and close them.

    Raises:
        GatewayError: one of them cannot listen; then none does.
    """
    with ExitStack() as stack:
        stack.callback(loop.close_sockets)
        if settings.auto_start:
            loop.clients.start_by(world.script_ports.named)
        opening = Opening(loop, settings)
        for entry in entries:
            if (gateway := entry.open(opening)) is not None:
                stack.callback(gateway.close)
                opening.opened.append(gateway)
        loop.watches.append(DescriptorWatch().look)
        stack.callback(loop.close)
        (zenoh,) = (each for each in opening.opened if isinstance(each, ZenohGateway))
        yield Gateways(zenoh, opening.opened)


def add_viewers(world: World, loop: ServerLoop, gateways: Gateways, *, has_viewer: bool) -> None:
    """Have the scene's scripts and the web viewer reach each other."""
    world.scripts.add_ons[ADD_ON] = Feed(loop, gateways.zenoh.realm, gateways.zenoh.ports)
    world.scripts.add_ons[WINDOWS] = Windows(has_viewer=has_viewer)
