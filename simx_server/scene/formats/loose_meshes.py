"""Contacts of single bodies made of meshes: blocks that programs bring into a scene come to rest and stay there.

MuJoCo finds few points of contact between a mesh and a plane, all near the deepest corner, and other ones in each
physics step. With its default contacts a block rocks on them, creeps and never sleeps. Firm contacts keep blocks within
0.1 mm of their geometry; a small rolling friction ends the rocking, like a face in full contact.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

_TIME_CONSTANT = 0.005
"""Time constant in seconds, as for loose objects of the shipped scenes; MuJoCo's default is 0.02."""

_ROLLING = 5e-4
"""Rolling friction in metres: largest distance between a contact's force and its point."""

_ALL_DIRECTIONS = 6
"""Dimensions of a contact: normal, sliding, torsion and rolling."""

_CONTACT = ("condim", "friction", "solref", "solimp")


def _defaults() -> Mapping[str, NDArray[np.float64]]:
    spec = mujoco.MjSpec()
    return {name: np.array(getattr(spec.default.geom, name)) for name in _CONTACT}


_DEFAULTS = _defaults()
"""MuJoCo's defaults for contacts."""


def settle(geom: Any) -> None:
    """Give a geom of an MjSpec the contacts of a loose block."""
    geom.solref[0] = _TIME_CONSTANT
    geom.condim = _ALL_DIRECTIONS
    geom.friction[2] = _ROLLING


def settle_loose_meshes(spec: mujoco.MjSpec) -> None:
    """Settle the meshes of free rigid bodies where the file leaves the contacts at MuJoCo's defaults."""
    for body in spec.worldbody.bodies:
        joints = _joints(body)
        if len(joints) == 1 and joints[0].type == mujoco.mjtJoint.mjJNT_FREE:
            for geom in _geoms(body):
                if geom.type == mujoco.mjtGeom.mjGEOM_MESH and _is_as_by_default(geom):
                    settle(geom)


def _is_as_by_default(geom: Any) -> bool:
    return all(np.array_equal(getattr(geom, name), default) for name, default in _DEFAULTS.items())


def _joints(body: Any) -> list[Any]:
    return [*body.joints, *(joint for child in body.bodies for joint in _joints(child))]


def _geoms(body: Any) -> list[Any]:
    return [*body.geoms, *(geom for child in body.bodies for geom in _geoms(child))]
