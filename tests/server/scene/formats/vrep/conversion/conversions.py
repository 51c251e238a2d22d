"""Conversions of single objects made by hand, and the scenes that come of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco

from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import VrepFile, VrepObject
from simx_server.scene.formats.vrep.report import Report
from simx_server.scene.objects import Scene
from simx_server.scene.poses.poses import Pose


def conversion_of(*items: VrepObject, **parts: Any) -> Conversion:
    """A conversion of a file with these objects, whose names are theirs."""
    file = VrepFile(
        name="made.ttt",
        serialization=25,
        program=(4, 6, 0),
        objects={item.handle: item for item in items},
        **parts,
    )
    names = {item.handle: item.name for item in items}
    return Conversion(file, mujoco.MjSpec(), Report(file.name), names)


Add = Callable[[Conversion, Any, mujoco.MjsBody, Pose], None]


def scene_of(conversion: Conversion, add: Add, at: Pose, *items: VrepObject) -> tuple[Scene, mujoco.MjModel]:
    """The scene of a conversion after objects were added to a body at (1, 2, 3)."""
    body = conversion.spec.worldbody.add_body(name="carrier", pos=[1, 2, 3])
    body.add_geom(size=[0.01] * 3)
    for item in items:
        add(conversion, item, body, at)
    conversion.write_notes()
    return build(conversion.spec, None)
