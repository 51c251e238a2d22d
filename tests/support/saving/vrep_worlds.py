"""Worlds of V-REP's files that are changed as scripts and clients do it, saved into such files, and loaded again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handler_calls import QuickPainter, World
from saved_worlds import opened
from world_listing import differences, listing

from simx_server.editing.saving.vrep.document import vrep_model, vrep_scene
from simx_server.scene.formats.vrep.container import unpack
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces

ROUNDED = 3e-6
"""Relative difference of numbers: colours and meshes are float32 in all files."""


class VrepWorld(World):
    """The world of a file; `do` calls functions of `sim`. `close_worlds` ends its scripts."""

    def __init__(self, file: Path) -> None:
        super().__init__(file=file, workspace=file.parent, painter=QuickPainter())
        opened(self)
        self.parts.scripts.allows_code = True
        self._names = Namespaces(self.parts, Script(1, ScriptKind.CUSTOMIZATION, -1, "test"))

    def do(self, function: str, *arguments: Any) -> Any:
        """The result of `sim.FUNCTION`."""
        found: Any = self._names.invoke(f"sim.{function}", list(arguments))
        return found[0] if len(found) == 1 else found

    def first(self, kind: ObjectKind) -> int:
        return self.sim.scene.of_kind(kind)[0]

    def body(self) -> bytes:
        """The uncompressed body of the saved scene, or of the only model that was opened as a scene."""
        return bytes(unpack(self.saved())[1])

    def saved(self) -> bytes:
        source = self.parts.origins.scene
        assert source is not None
        if not source.is_model:
            return vrep_scene(self.parts).data
        top = self.sim.scene.children(-1)
        (base,) = [handle for handle in top if self.parts.origins.of(handle)]
        return vrep_model(self.parts, base).data

    def reloaded(self, file: Path) -> VrepWorld:
        """Another world, of this one's saved file."""
        file.write_bytes(self.saved())
        return VrepWorld(file)


def changes(before: World, after: World, *ignored: str) -> list[str]:
    """One line for each quantity that differs; those that contain one of the words are left out.

    The numbers of MuJoCo's elements are left out: what was removed leaves some behind until the scene is loaded again.
    """
    ignored = (
        *ignored,
        "the scene.counts",
        "the scene.constants",
        "the scene.objects",
        "property childOrder",
    )
    found = differences(listing(before.parts), listing(after.parts), tolerance=ROUNDED)
    return [line for line in found if not any(word in line for word in ignored)]
