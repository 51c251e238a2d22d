"""The parts between a world and its clients: server loop and gateways, of servers and of embedded servers."""

from __future__ import annotations

import logging
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from simx_client.protocol.add_ons.windows import ADD_ON as WINDOWS
from simx_client.protocol.lane.offer import is_possible
from simx_client.protocol.messages import Pace
from simx_client.protocol.zenoh import link
from simx_server.gateways.descriptors import DescriptorWatch
from simx_server.gateways.errors import GatewayError
from simx_server.gateways.lane.gateway import LocalGateway
from simx_server.gateways.original.listener import LegacyGateway
from simx_server.gateways.script_doors import ScriptDoors
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

if TYPE_CHECKING:
    from simx_server.gateways.ros2.gateway import Ros2Gateway

logger = logging.getLogger(__name__)


def make_loop(world: World, settings: Settings) -> ServerLoop:
    """Return the server loop of a world, not running yet."""
    pacer, parameters = Pacer(settings.speed), world.parameters
    starting_port = settings.temporary_port if settings.auto_start else None
    loop = ServerLoop(world, HANDLERS, pacer, starting_port=starting_port)
    loop.metrics.pictures = world.rendering.times
    loop.watches.append(world.rendering.watch)
    parameters.pace = pacer
    parameters.is_waiting_for_trigger = lambda: loop.is_waiting_for_trigger
    parameters.end = loop.end_when_left
    loop.history = History(loop, settings.history)
    return loop


@contextmanager
def open_gateways(world: World, settings: Settings, loop: ServerLoop) -> Generator[ZenohGateway]:
    """Open the ways in for other processes within the block; then end the clients' calls and close them.

    Returns:
        The gateway at the server's ports.

    Raises:
        GatewayError: one of them cannot listen; then none does.
    """
    try:
        gateway, others, legacy_ports = _open_gateways(settings, loop)
    except GatewayError:
        loop.close_sockets()
        raise
    world.simulation.attach(gateway)
    loop.watches.append(DescriptorWatch().look)
    with ExitStack() as stack:
        stack.callback(gateway.close)
        stack.callback(loop.close_sockets)
        stack.callback(others.close)
        _open_script_ports(world, settings, loop, [*gateway.ports, *legacy_ports], stack)
        stack.callback(loop.close)
        yield gateway


def add_viewers(world: World, loop: ServerLoop, gateway: ZenohGateway, *, has_viewer: bool) -> None:
    """Have the scene's scripts and the web viewer reach each other."""
    world.scripts.add_ons[ADD_ON] = Feed(loop, gateway.realm, gateway.ports)
    world.scripts.add_ons[WINDOWS] = Windows(has_viewer=has_viewer)


def _open_gateways(settings: Settings, loop: ServerLoop) -> tuple[ZenohGateway, ExitStack, Sequence[int]]:
    """Open the ways in.

    Returns:
        The gateway at the server's ports, a stack that closes the others, and the ports for original clients.

    Raises:
        GatewayError: one of them cannot listen; then none does.
    """
    with ExitStack() as stack:
        local = _open_local(settings, loop)
        if local is not None:
            stack.callback(local.close)
        gateway = ZenohGateway(
            loop,
            ports=settings.ports,
            listen=settings.listen,
            connect=settings.connect,
            realm=settings.realm,
            config=settings.config,
            multicast_scouting=settings.multicast_scouting,
            local=local,
        )
        stack.callback(gateway.close)
        others = stack.enter_context(ExitStack())
        if local is not None:
            others.callback(local.close)
        legacy = LegacyGateway(loop, settings.legacy_ports, Pace[settings.legacy_pace.upper()])
        others.callback(legacy.close)
        gateway.more_endpoints += [f"legacy/{address}" for address in legacy.endpoints]
        for address, may_only_read in ((settings.zmq, False), (settings.zmq_viewers, True)):
            if address is None:
                continue
            from simx_server.gateways.zmq.gateway import ZmqGateway  # slow, and often not needed

            further = ZmqGateway(loop, address, may_only_read=may_only_read)
            others.callback(further.close)
            gateway.more_endpoints.append(further.endpoint)
        if settings.ros2 is not None:
            node = _open_ros2(settings, settings.ros2, loop)
            others.callback(node.close)
            gateway.more_endpoints.append(node.endpoint)
        kept = others.pop_all()
        stack.pop_all()
    return gateway, kept, legacy.ports


def _open_ros2(settings: Settings, domain: int, loop: ServerLoop) -> Ros2Gateway:
    """Be a node of ROS 2. Raises GatewayError: it cannot be the router, as it is told to."""
    from simx_server.gateways.ros2.gateway import Ros2Gateway, Ros2Options  # slow, and often not needed
    from simx_server.gateways.ros2.wire.names import Distribution, Place
    from simx_server.gateways.ros2.wire.session import Router

    humble, newer = Distribution.HUMBLE, Distribution.NEWER
    options = Ros2Options(
        place=Place(domain, settings.ros2_namespace or ""),
        router=Router.of(settings.ros2_router),
        distribution=humble if settings.ros2_distro == "humble" else newer,
        readers=link.READERS if settings.config is None and not settings.multicast_scouting else 0,
    )
    return Ros2Gateway(loop, options)


def _open_local(settings: Settings, loop: ServerLoop) -> LocalGateway | None:
    """Open the short way for clients on this host; a configuration may have rules that it would pass by."""
    if not settings.local or settings.config is not None or not is_possible():
        return None
    try:
        return LocalGateway(loop)
    except OSError as problem:
        logger.warning("clients on this host use Zenoh alone: no socket could be made: %s", problem)
        return None


def _open_script_ports(
    world: World, settings: Settings, loop: ServerLoop, own: Sequence[int], stack: ExitStack
) -> None:
    """Open the ports at which the scene's scripts start the remote API; ``stack`` closes them."""
    if settings.auto_start:
        loop.more_starting_ports = world.script_ports.named
    if settings.script_ports:
        pace = Pace[settings.legacy_pace.upper()] if settings.legacy_ports else None
        doors = ScriptDoors(loop, own, settings.config, legacy_pace=pace)
        stack.callback(doors.close_all)
        loop.watches.append(doors.look)
        world.script_ports.serve(doors)
