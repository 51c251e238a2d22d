"""The namespace ``simURDF``: robots of URDF files."""

from __future__ import annotations

import mujoco

from simx_client.protocol import constants
from simx_server.errors import CommandError
from simx_server.handlers.objects.objects import set_model_property
from simx_server.handlers.scene_files import script_files
from simx_server.scene.objects import ObjectKind
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import writes_files

_NO_MODEL, _NO_POSITION_CONTROL = 64, 256
"""Bits of options."""

_NOT_MODEL = constants.sim_modelproperty_not_model

_SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


class SimUrdf(ApiPart, effect="changes"):
    """Functions for robots of URDF files in the workspace, or of those that come with the server."""

    @writes_files
    def export(self, _model: int, _file: str, _options: int = 0) -> None:
        """Raise an error. Not here: models are saved by sim.saveModel, and as MJCF by simx-server --convert."""
        raise CommandError(
            "models are not written as URDF; sim.saveModel saves one, and simx-server --convert writes a scene as MJCF"
        )


def _import(
    self: SimUrdf, file: str, options: int = 0, _replacement: str | None = None
) -> tuple[str, list[int]]:
    """Load a robot, select its base; return its name and the handles of its objects. `options`: 64 the base does not
    become a model, 256 joints start without position control.

    Partly: other options are ignored: the robot is lifted above the floor, and shows its visual meshes. Names with
    ``package://`` are found in the workspace.
    """
    world, sim = self._world, self._sim  # pyright: ignore[reportPrivateUsage]
    base = script_files.load_model_of_server(world, file)
    handles = [base, *sim.scene.descendants(base)]
    if options & _NO_MODEL:
        set_model_property(world, base, _NOT_MODEL)
    if options & _NO_POSITION_CONTROL:
        for handle in handles:
            item = sim.scene.get(handle)
            if item.kind is ObjectKind.JOINT and sim.model.jnt_type[item.id] in _SINGLE:
                sim.joints.change(handle, control_loop=False)
    return sim.scene.get(base).alias, handles


setattr(SimUrdf, "import", _import)
