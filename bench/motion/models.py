"""Models without a scene: read, changed as a specification, and built as a world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from simx_server.app.building import build_world
from simx_server.scene.formats.annotations import PREFIX
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.specs import read_spec
from simx_server.world.world import World

_SHIPPED_SCENES = Path(__file__).parents[2] / "scenes"


def read_model(file: Path, *, scripted: bool) -> Any:
    """Return the specification of a model of any format, with or without its scripts."""
    spec: Any = read_spec(file.resolve()).spec
    if not scripted:
        for text in list(spec.texts):
            if text.name.startswith((f"{PREFIX}script:", f"{PREFIX}lua:")):
                spec.delete(text)
    if file.suffix == ".xml":
        _set_shipped_physics(spec)
    return spec


def build_model(spec: Any, file: Path) -> World:
    """Return a world of this model only."""
    world = build_world(None, workspace=None)  # pyright: ignore[reportArgumentType]
    world.simulation.use(*build(spec, file))
    return world


def _set_shipped_physics(spec: Any) -> None:
    """Simulate a shipped model as in the shipped scenes."""
    settings: Any = mujoco.MjSpec.from_file(str(_SHIPPED_SCENES / "ur5_rg2_kinect.xml"))
    for name in ("timestep", "integrator", "cone", "impratio", "noslip_iterations"):
        setattr(spec.option, name, getattr(settings.option, name))
