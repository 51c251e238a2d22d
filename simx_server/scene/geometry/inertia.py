"""Mass, centre of mass and inertia of a shape's body: read them, set them, compute them from its geoms."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.editing.model_changes import undone_on_failure
from simx_server.scene.editing.recompile import edit
from simx_server.scene.formats.loader import compile_spec
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

Array = NDArray[np.float64]

_LEAST = 1e-9
"""Least mass in kilograms and inertia in kg m^2; MuJoCo cannot step a moving body with less."""


def get_inertia(sim: LiveScene, handle: int) -> tuple[float, Array, Array]:
    """Return mass in kg; (3, 3) inertia about the centre of mass in kg m^2 and (3,) centre of mass in m.

    Both are given along the axes of the shape's own frame.

    Raises UnknownHandle, WrongKind, CommandError: a part of the world, which has none.
    """
    body = _body(sim, handle)
    model = sim.model
    turn = _rotation(model.body_iquat[body])
    inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
    return float(model.body_mass[body]), inertia, model.body_ipos[body].copy()


def set_inertia(sim: LiveScene, handle: int, mass: float, inertia: Array, centre: Array) -> None:
    """Set the values that `get_inertia` returns. The stop undoes a change during a run.

    Raises UnknownHandle, WrongKind, CommandError: a part of the world, or an inertia that a body cannot have.
    """
    body = _body(sim, handle)
    name = sim.model.body(body).name
    moments, axes = np.linalg.eigh((inertia + inertia.T) / 2)
    if not np.isfinite([mass, *inertia.ravel(), *centre]).all() or mass < _LEAST or moments[0] < _LEAST:
        raise CommandError("a mass and the moments of inertia must be above 0")
    if moments[0] + moments[1] < moments[2] * (1 - 1e-6):
        raise CommandError(
            f"the principal moments of inertia {moments.tolist()} belong to no body: none may be above the sum of the "
            "others"
        )
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, axes.ravel())

    def surgery(spec: mujoco.MjSpec) -> None:
        target = spec.body(name)
        target.explicitinertial = True
        target.mass = mass
        target.ipos[:], target.iquat[:], target.inertia[:] = centre, quat, moments
        target.fullinertia[:] = np.nan
        target.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT

    with undone_on_failure(sim):
        # This is an edit, because MuJoCo's compiler treats a body with a simple inertia differently.
        edit(sim, surgery, set(), reweighed={name})
        model = sim.model
        body = model.body(name).id
        model.body_mass[body], model.body_inertia[body] = mass, moments
        model.body_ipos[body], model.body_iquat[body] = centre, quat
        sim.joints.masses_changed()
    sim.model_edited()
    sim.changed()


def compute_inertia(sim: LiveScene, handle: int, density: float) -> None:
    """Set mass and inertia of a shape from its geoms, filled with kg/m^3. Raises as `set_inertia`."""
    if not density > 0:
        raise CommandError(f"a density must be above 0 kg/m^3, not {density}")
    name = sim.model.body(_body(sim, handle)).name
    spec = sim.scene.spec.copy()
    target = spec.body(name)
    target.explicitinertial = False
    target.mass, target.inertia[:] = 0.0, 0.0
    # The compiler takes the values of a body whose centre of mass is a number, whatever the flag says.
    target.ipos[:] = (np.nan, 0.0, 0.0)
    target.fullinertia[:] = (np.nan, 0.0, 0.0, 0.0, 0.0, 0.0)
    for geom in target.geoms:
        geom.mass, geom.density = np.nan, density
    try:
        model = compile_spec(spec, logging.DEBUG)
    except (ValueError, mujoco.FatalError) as error:
        raise CommandError(f"no mass can be computed: {' '.join(str(error).split())}") from error
    body = model.body(name).id
    turn = _rotation(model.body_iquat[body])
    inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
    set_inertia(sim, handle, float(model.body_mass[body]), inertia, model.body_ipos[body].copy())


def _body(sim: LiveScene, handle: int) -> int:
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if item.element != "body":
        raise CommandError(f"'{item.name}' is a part of the world, which has no mass")
    return item.body


def _rotation(quat_wxyz: Array) -> Array:
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, quat_wxyz)
    return flat.reshape(3, 3)
