"""Settings of one client: stepped mode and its error texts."""

from __future__ import annotations

from concurrent.futures import Future
from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler
from simx_server.simulation.simulation import SimulationState

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World


@handler("simxSynchronous", with_client=True)
def synchronous(world: World, client: ClientSession, enable: bool) -> None:
    """Accept the call while stopped too; the first step then needs a trigger."""
    client.set_stepping(enable)


@handler("simxSynchronousTrigger", with_client=True)
def synchronous_trigger(world: World, client: ClientSession) -> Future[None]:
    """Return after the simulation step; the original returned before it, and reading needed a ping first."""
    return client.trigger(is_running=world.simulation.state is SimulationState.RUNNING)


@handler("simxGetLastErrors", with_client=True)
def get_last_errors(world: World, client: ClientSession) -> list[str]:
    """Return an empty list if the previous call returned all errors."""
    texts = list(client.errors)
    client.errors.clear()
    return texts
