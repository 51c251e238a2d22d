"""The namespace ``simURDF``: robots of URDF files."""

from __future__ import annotations

from simx_server.errors import CommandError
from simx_server.handlers import script_files
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import writes_files


class SimUrdf(ApiPart, effect="changes"):
    """Functions for robots of URDF files in the workspace, or of those that come with the server."""

    @writes_files
    def export(self, _model: int, _file: str, _options: int = 0) -> None:
        """Raise an error. Not here: models are saved by sim.saveModel, and as MJCF by simx-server --convert."""
        raise CommandError(
            "models are not written as URDF; sim.saveModel saves one, and simx-server --convert writes a scene as MJCF"
        )


def _import(self: SimUrdf, file: str, _options: int = 0, _replacement: str | None = None) -> str:
    """Load a robot, select its base and return its name.

    Partly: options are ignored: the robot is a model, stands where the file puts it, and shows its visual meshes. Names
    with ``package://`` are found in the workspace.
    """
    base = script_files.load_model_of_server(self._world, file)  # pyright: ignore[reportPrivateUsage]
    return self._sim.scene.get(base).alias  # pyright: ignore[reportPrivateUsage]


setattr(SimUrdf, "import", _import)
