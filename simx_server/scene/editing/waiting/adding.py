"""Add objects whose model is compiled later; see `waiting.py`."""

from __future__ import annotations

from collections.abc import Collection, Set
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.editing.recompile import refuse_in_physics
from simx_server.scene.naming.names import alias_of
from simx_server.scene.objects import SceneObject
from simx_server.scene.tree import Addition

from .blueprint import Change
from .templates import Template
from .waiting import Waiting

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene


@dataclass(frozen=True)
class Late:
    """Objects that wait for the compile."""

    template: Template
    change: Change
    """Adds the elements to the spec."""
    weight: float
    """How much that is, as a number of bodies."""
    added: Addition
    moved: Set[tuple[str, str]] = frozenset()
    """(array prefix, element name) of elements with a separate place, though they are copies."""
    welded: Collection[str] = ()
    weightless: Collection[str] = ()
    """Names of bodies that belong to the scene's sets of this name."""


def add_objects(sim: LiveScene, late: Late) -> None:
    """Add objects at the top of the tree. `may_add` and `Template.fits` say whether they can be added so.

    Raises CommandError: the scene has too many objects.
    """
    added, template = late.added, late.template
    sim.limits.check("objects", len(sim.scene.objects) + len(added.names), "remove some")
    waiting = sim.waiting or Waiting.of(sim.scene, sim.model, sim.data)
    scene = waiting.scene
    known = scene.annotations
    scene.annotations = replace(known, objects={**known.objects, **added.annotations})
    handles = {each.handle: scene.next_handle + place for place, each in enumerate(template.objects)}
    handles[-1] = -1
    items = [_item(waiting, added, each, handles) for each in template.objects]
    scene.append(items)
    scene.override_parents({handles[child]: handles[parent] for child, parent in template.parents.items()})
    scene.owners = np.append(scene.owners, [handles[owner] for owner in template.owners])
    scene.hidden_bodies |= added.hidden
    scene.welded_bodies.update(late.welded)
    scene.weightless_bodies.update(late.weightless)
    waiting.moved |= late.moved
    waiting.weighed.update(added.hidden, late.weightless)
    if added.copies:
        waiting.copies.add(added.prefix)
    waiting.starts.append(added.start)
    loose = {
        item.handle for item, each in zip(items, template.objects, strict=True) if _is_loose(each, template)
    }
    waiting.added([item.handle for item in items], loose, late.change, late.weight)
    for kind, count in template.sizes.items():
        waiting.sizes[kind] += count
    sim.hold(waiting)


def may_add(sim: LiveScene, added: Addition) -> bool:
    """Return whether objects can wait for the compile. Raises CommandError: within a physics step."""
    refuse_in_physics(sim)
    return (
        sim.scene.keeps_ids
        and not any(added.registered.values())
        and (sim.waiting is not None or not sim.scene.blueprint.reads_meshes)
    )


def _item(waiting: Waiting, added: Addition, each: SceneObject, handles: dict[int, int]) -> SceneObject:
    """Return an object of the scene like one of a template. `handles`: those of the template to the scene's."""
    sizes, element_name = waiting.sizes, added.prefix + each.element_name
    name = added.names[each.element, element_name]
    notes = waiting.scene.annotations.objects.get(name, {})
    return SceneObject(
        handle=handles[each.handle],
        name=name,
        kind=each.kind,
        parent=handles[each.parent],
        element=each.element,
        element_name=element_name,
        id=sizes[each.element] + each.id,
        body=sizes["body"] + each.body,
        alias=str(notes.get("object", {}).get("alias", alias_of(name))),
        annotations=notes,
        sensors=tuple(sizes["sensor"] + sensor for sensor in each.sensors),
    )


def _is_loose(item: SceneObject, template: Template) -> bool:
    return item.element == "body" and item.id in template.loose
