"""A process makes the common parts of all its servers before it forks them."""

from __future__ import annotations

from scenes_for_tests import world_of

from simx_server import sim_api as api
from simx_server.app.preparing import prepare
from simx_server.scripting.lua import prepared
from simx_server.settings.settings import Settings
from simx_server.sim_api.namespaces import Namespaces, signatures


def test_a_server_that_clients_of_zeromq_reach_finds_the_api_described() -> None:
    for made in (signatures, Namespaces.names, prepared.chunks):
        made.cache_clear()
    world = world_of("<mujoco/>")
    prepare(world, Settings())
    assert not prepared.chunks.cache_info().currsize
    prepare(world, Settings(zmq="127.0.0.1:0"))
    assert signatures.cache_info().currsize == len(api.NAMESPACES)
    assert prepared.chunks.cache_info().currsize
