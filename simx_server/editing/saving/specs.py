"""The spec that is saved: that of the scene, or a part of it with its assets, with what commands have changed since."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import mujoco

from simx_server.editing.grafts.pruning import Pruned
from simx_server.editing.grafts.selecting import Selection
from simx_server.scene.editing.copies.element_copies import Copier, agree
from simx_server.scene.editing.model_state import option_values
from simx_server.scene.editing.saving.settling import settle
from simx_server.scene.editing.transplant import move_body
from simx_server.scene.editing.waiting.basis import Basis
from simx_server.scene.formats.loader import compile_spec
from simx_server.scene.geometry.highlights import SPECULAR
from simx_server.scene.poses.placing import body_pose
from simx_server.scene.spec_elements import leaves_of

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_AS_IT_IS = Copier(lambda name: name)

_COMPILING = (
    *("alignfree", "autolimits", "balanceinertia", "boundinertia", "boundmass", "discardvisual"),
    *("fitaabb", "inertiafromgeom", "settotalmass", "degree", "eulerseq"),
)
"""Settings of MuJoCo's compiler on which the model depends."""


@dataclass(frozen=True)
class PreparedSpec:
    """A spec whose elements have the names that they have in the scene's model."""

    spec: mujoco.MjSpec
    hidden: Collection[str] = ()
    """Names of its bodies without an object."""
    moved: Collection[tuple[str, str]] = field(default_factory=set[tuple[str, str]])
    """(array prefix, element name) of what has another place than in the scene's spec."""


def spec_of_scene(sim: Simulation) -> PreparedSpec:
    """Return the whole spec."""
    return PreparedSpec(sim.scene.spec.copy(), sim.scene.hidden_bodies)


def spec_of_objects(sim: Simulation, handles: Collection[int]) -> PreparedSpec:
    """Return the part of the spec that has these objects, with the assets that they use.

    Raises:
        CommandError: the part has plugins.
    """
    whole = sim.scene.spec
    pruned = Pruned(Selection(sim, Basis.of(sim), handles))
    part = pruned.spec
    agree(part, whole)
    for name in _COMPILING:
        setattr(part.compiler, name, getattr(whole.compiler, name))
    part.compiler.inertiagrouprange[:] = whole.compiler.inertiagrouprange
    part.meshdir, part.texturedir, part.modelfiledir = whole.meshdir, whole.texturedir, whole.modelfiledir
    part.assets = dict(whole.assets)
    _add_assets(part, whole)
    return PreparedSpec(part, sim.scene.hidden_bodies | pruned.carriers, pruned.moved)


def _add_assets(part: mujoco.MjSpec, whole: mujoco.MjSpec) -> None:
    """Add the meshes, materials and so on that elements of a spec name."""
    geoms = leaves_of(part, "geoms")
    meshes, fields = {each.meshname for each in geoms}, {each.hfieldname for each in geoms}
    materials = {each.material for each in (*geoms, *leaves_of(part, "sites"), *part.tendons)}
    _copy(whole.meshes, meshes, part.add_mesh)
    _copy(whole.hfields, fields, part.add_hfield)
    materials |= {each.material for each in part.meshes if hasattr(each, "material")}
    _copy(whole.materials, materials, part.add_material)
    _copy(whole.textures, {name for each in part.materials for name in each.textures}, part.add_texture)
    for numeric in whole.numerics:
        if numeric.name.startswith(SPECULAR) and numeric.name.removeprefix(SPECULAR) in materials:
            part.add_numeric(name=numeric.name, data=list(numeric.data), size=numeric.size)


def _copy(assets: Iterable[Any], names: Collection[str], add: Any) -> None:
    for asset in assets:
        if asset.name and asset.name in names:
            _AS_IT_IS.element(asset, add())


def bring_up_to_date(sim: Simulation, prepared: PreparedSpec) -> mujoco.MjModel | None:
    """Write into a spec what commands have changed in the model: numbers, options, active constraints.

    Returns:
        The model that the spec gives, as far as its elements and their numbers count; None: it must be compiled again.
    """
    spec, scene = prepared.spec, sim.scene
    for numeric in list(spec.numerics):  # annotations; they are written again
        if numeric.name == "simx:time_step":
            spec.delete(numeric)
    compiled = compile_spec(spec, logging.DEBUG)
    has_changed = settle(
        spec,
        compiled,
        sim.model,
        withheld=scene.withheld,
        weightless=scene.weightless_bodies,
        moved=prepared.moved,
    )
    for name, value in option_values(sim.model.opt).items():
        if hasattr(value, "shape"):
            getattr(spec.option, name)[:] = value
        else:
            setattr(spec.option, name, value)
    spec.option.timestep = sim.physics_step
    for equality in spec.equalities:
        index = mujoco.mj_name2id(sim.model, mujoco.mjtObj.mjOBJ_EQUALITY, equality.name)
        if index >= 0:
            equality.active = bool(sim.data.eq_active[index])
    for name in scene.made_static:  # only a property of the model holds them
        body = mujoco.mj_name2id(sim.model, mujoco.mjtObj.mjOBJ_BODY, name)
        if body >= 0 and spec.body(name) is not None:
            move_body(spec, name, "world", body_pose(sim, body), free=True)
            has_changed = True
    return None if has_changed else compiled
