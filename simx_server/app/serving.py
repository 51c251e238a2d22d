"""The parts between a world and its clients: server loop and gateways, of servers and of embedded servers."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager

from simx_client.protocol.add_ons.windows import ADD_ON as WINDOWS
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.gateways.gateway import Entry, Gateway, Opening
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.handlers import HANDLERS
from simx_server.history import History
from simx_server.service.clock import Pacer
from simx_server.service.service import Service, build_service
from simx_server.settings.settings import Settings
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import ADD_ON
from simx_server.viewer.windows import Windows
from simx_server.world.world import World

from .extensions import GATEWAYS, WATCHERS, Watching


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


def make_service(world: World, settings: Settings) -> Service:
    """Return the service of a world."""
    pacer, parameters = Pacer(settings.speed), world.parameters
    starting_port = settings.temporary_port if settings.auto_start else None
    service = build_service(world, HANDLERS, pacer, starting_port=starting_port, images=world.rendering.times)
    parameters.served_by(pacer, lambda: service.due.is_waiting_for_trigger, service.ending.when_left)
    return service


def add_watchers(service: Service, settings: Settings, *, warms_up: bool) -> History:
    """Make the watchers of a server, and have them watch; return the history among them."""
    server = Watching(service, settings, warms_up)
    watchers = [watcher for make in WATCHERS if (watcher := make(server)) is not None]
    service.watchers.add(*watchers)
    (history,) = (each for each in watchers if isinstance(each, History))
    return history


@contextmanager
def open_gateways(
    world: World, settings: Settings, service: Service, entries: Sequence[Entry] = GATEWAYS
) -> Generator[Gateways]:
    """Open the gateways within the block; then end the clients' calls and close them.

    Raises:
        GatewayError: one of them cannot listen; then none does.
    """
    with ExitStack() as stack:
        stack.callback(service.queue.close_sockets)
        if settings.auto_start:
            service.clients.start_by(world.script_ports.named)
        opening = Opening(service, settings)
        for entry in entries:
            if (gateway := entry.open(opening)) is not None:
                stack.callback(gateway.close)
                opening.opened.append(gateway)
        stack.callback(service.clients.abandon_calls)
        (zenoh,) = (each for each in opening.opened if isinstance(each, ZenohGateway))
        yield Gateways(zenoh, opening.opened)


def add_viewers(
    world: World, service: Service, history: History, gateways: Gateways, *, has_viewer: bool
) -> None:
    """Have the scene's scripts and the web viewer reach each other."""
    world.scripts.add_ons[ADD_ON] = Feed(service, gateways.zenoh.realm, gateways.zenoh.ports, history)
    world.scripts.add_ons[WINDOWS] = Windows(has_viewer=has_viewer)
