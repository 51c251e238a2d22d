"""The object `remoteApiCommandServer` in every scene, for programs that call its functions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.editing.models import load_model
from simx_server.files.library import shipped_models
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.world.world import World

COMMAND_SERVER = "remoteApiCommandServer"


def add_command_server(world: World) -> None:
    """Add it to the scene unless the scene has one. Call this after a scene was loaded."""
    if world.simulation.scene.by_name(COMMAND_SERVER) is None:
        load_model(world, shipped_models() / "remote_api_command_server.xml")


class CommandServer(Part):
    """Add the object to every scene that is loaded."""

    def __init__(self, world: World) -> None:
        self._world = world

    def scene_loaded(self) -> None:
        add_command_server(self._world)
