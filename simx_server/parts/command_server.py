"""The object `remoteApiCommandServer` in every scene, for programs that call its functions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.files.library import shipped_models
from simx_server.scene.models import load_model

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

COMMAND_SERVER = "remoteApiCommandServer"


def add_command_server(sim: Simulation) -> None:
    """Add it to the scene unless that has one. To be called when a scene was loaded."""
    if sim.scene.by_name(COMMAND_SERVER) is None:
        load_model(sim, shipped_models() / "remote_api_command_server.xml")
