"""The only function that replaces a scene's model: operate on a copy of the spec, compile, carry the state over."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.assets.filing import file_assets
from simx_server.scene.formats.loader import SceneError, compile_spec, take_weight
from simx_server.scene.tree import Addition

from .successor import succeed
from .transfer import carry_over
from .twins import Names, Twins
from .waiting.blueprint import Blueprint

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene

    from .in_place.slots import Slots

Surgery = Callable[[mujoco.MjSpec], None]


def edit(
    sim: LiveScene,
    surgery: Surgery,
    moved: set[tuple[str, str]],
    *,
    removed: set[int] | None = None,
    parents: dict[int, int] | None = None,
    welded: set[str] | None = None,
    hidden: str | None = None,
    weightless: set[str] | None = None,
    added: Addition | None = None,
    reweighed: Collection[str] = (),
    repeats: float | None = None,
) -> None:
    """Operate on a copy of the spec, compile it, carry the state over. A failure leaves all as it was.

    Args:
        moved: (array prefix, element name) of elements with a new pose, see `carry_over`.
        removed: handles of removed objects.
        parents: handle to new parent, of objects whose place in the tree is not that of their element.
        welded, weightless: the scene's sets of these names from now on.
        hidden: name of one more body without an object.
        added: the spec that the surgery adds.
        reweighed: names of bodies whose mass and inertia the surgery sets.
        repeats: the surgery only adds, as much as this number of bodies, and can be made again in other copies.
    """
    refuse_in_physics(sim)
    sim.refresh()
    old = sim.scene
    if added is not None:
        sim.limits.check("objects", len(old.objects) + len(added.names), "remove some")
    slots = old.slots.renewed()
    weights = old.weightless_bodies if weightless is None else weightless
    copies = (added.prefix,) if added is not None and added.copies else ()
    # A body that only replaces a copy's missing link keeps its given weight.
    own_weight = {
        *reweighed,
        *(old.weightless_bodies ^ weights),
        *(added.hidden if added is not None else ()),
    }
    try:
        if repeats is not None:
            blueprint = old.blueprint.then(surgery, repeats)
        else:
            spec = old.blueprint.copy()
            surgery(spec)
            file_assets(spec)
            blueprint = Blueprint(spec)
        model = compile_edited(blueprint, old, slots)
    except (ValueError, mujoco.FatalError, SceneError) as error:
        raise refusal(error) from error
    data = mujoco.MjData(model)
    twins = Twins(old.names or Names(sim.model), model)
    differs = carry_over(sim.model, sim.data, model, data, twins, moved, own_weight, copies)
    if added is not None:
        added.start.put_into(model, data)
    differs |= take_weight(model, weights)
    if differs:
        set_constants(model)
    hidden_bodies = old.hidden_bodies | ({hidden} if hidden is not None else set[str]())
    annotations, names = old.annotations, None
    if added is not None:
        hidden_bodies |= added.hidden
        # New mappings: the stop may restore the old ones.
        annotations = replace(
            annotations,
            objects={**annotations.objects, **added.annotations},
            registered={
                kind: {**annotations.registered.get(kind, {}), **added.registered.get(kind, {})}
                for kind in annotations.registered.keys() | added.registered.keys()
            },
        )
        names = added.names
    scene, touched = succeed(
        old, sim.model, blueprint, model, twins, annotations, hidden_bodies, names, frozenset(slots.sites)
    )
    scene.slots = slots
    scene.model_properties = {h: bits for h, bits in old.model_properties.items() if h in scene.objects}
    scene.files, scene.names = old.files, twins.new
    scene.made_static = set(old.made_static)
    geoms: set[str] = set(twins.new.of("geom")) if old.withheld else set()
    scene.withheld = {key: value for key, value in old.withheld.items() if key[0] in geoms}
    scene.welded_bodies = set(old.welded_bodies if welded is None else welded)
    scene.weightless_bodies = set(weights)
    for handle in removed or ():
        scene.objects.pop(handle, None)
    parents = {handle: parent for handle, parent in (parents or {}).items() if handle in scene.objects}
    for handle in parents:
        scene.objects[handle] = replace(scene.objects[handle])  # the old scene stays if this one fails
    scene.override_parents(parents)
    scene.reindex()
    _check_tree(scene, touched | parents.keys())
    sim.replace_model(scene, model, data, twins)


def compile_edited(blueprint: Blueprint, old: Scene, slots: Slots) -> mujoco.MjModel:
    """Compile an edited scene. Raises as `spec.compile`.

    Args:
        old: the scene before the edit.
        slots: the model gets these too.
    """
    # The warnings were logged when the scene was loaded.
    return compile_spec(blueprint.draft(len(old.owners)), logging.DEBUG, old.files, slots, True)


def set_constants(model: mujoco.MjModel) -> None:
    """Compute the solver's values from masses and places: the carried ones differ from the compiled ones.

    Raises CommandError: MuJoCo cannot.
    """
    try:
        mujoco.mj_setConst(model, mujoco.MjData(model))
    except mujoco.FatalError as error:  # a client may have set weights to 0
        raise refusal(error) from error


def refuse_in_physics(sim: LiveScene) -> None:
    """Raise CommandError within a physics step, whose callbacks cannot edit the scene."""
    sim.physics_calls.refuse("objects cannot be made, loaded, removed or put elsewhere in the tree")


def refusal(error: Exception) -> CommandError:
    """Return the error of an edit that MuJoCo refuses."""
    return CommandError(f"the scene cannot be changed that way: {' '.join(str(error).split())}")


def _check_tree(scene: Scene, touched: set[int]) -> None:
    """Raise CommandError where an object would be its own ancestor. `touched`: handles whose parent may have changed.

    The model's tree and the given parents may contradict each other: a moved body takes along joints and sensors that
    are elsewhere in the tree.
    """
    sound: set[int] = {-1}
    for handle in touched:
        way: list[int] = []
        while handle not in sound:
            if handle in way:
                names = ", ".join(f"'{scene.objects[each].name}'" for each in way[way.index(handle) :])
                raise CommandError(
                    f"that would make each of {names} an ancestor of itself; give one another parent first"
                )
            way.append(handle)
            handle = scene.objects[handle].parent if handle in scene.objects else -1
        sound.update(way)
