"""Add a whole spec to a scene: the common part of loading a model and copying objects.

The elements get a unique prefix; their objects get V-REP's names, with copy numbers where names are taken.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import field
from itertools import takewhile
from typing import TYPE_CHECKING

import mujoco

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.editing.copies.element_copies import Copier
from simx_server.scene.editing.copies.joining import join, weight_of
from simx_server.scene.editing.copies.straight import Straight
from simx_server.scene.editing.recompile import edit
from simx_server.scene.editing.transplant import strip
from simx_server.scene.editing.waiting.adding import Late, add_objects, may_add
from simx_server.scene.editing.waiting.templates import Template
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.naming.names import GRAFT_END, copy_names
from simx_server.scene.poses.start import Start
from simx_server.scene.registered import renamed, renamed_registered
from simx_server.scene.tree import Addition

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

Element = tuple[str, str]
"""Element that carries an object: the MuJoCo kind and the element's name."""


@dataclass(frozen=True)
class Graft:
    """The part to add, with its names and annotations."""

    part: mujoco.MjSpec | Straight
    """The part to add; a spec belongs to the scene from then on."""
    names: Mapping[Element, str]
    """The original name of each object that it carries."""
    annotations: Mapping[str, dict[str, Annotation]]
    """Annotations by these names."""
    registered: Mapping[str, Mapping[str, Annotation]] = field(
        default_factory=dict[str, Mapping[str, Annotation]]
    )
    """Collections, collision and distance objects, IK groups and old custom UIs of the spec: per kind, by name."""
    copies: bool = False
    """Whether each element has the name of one in the scene, whose state it takes over."""
    moved: Collection[Element] = ()
    """(array prefix, element name) of copies that have a new place in the model."""
    hidden: Collection[str] = ()
    """Names of its bodies without an object."""
    welded: Collection[str] = ()
    weightless: Collection[str] = ()
    """Names of its bodies that belong to the scene's sets of this name."""
    start: Start = field(default_factory=Start)
    """Positions of its joints, where they are not those of its bodies."""
    template: Callable[[], Template | None] = lambda: None
    """Returns the objects as they are before the compile, so that it can wait; None: it cannot."""


def graft(sim: Simulation, addition: Graft, *, late: bool = False) -> dict[Element, int]:
    """Add objects at the top of the tree, stopped or running; return the handle of each object by element.

    An object without its element (a tendon without its sites) is left out. Raises CommandError.

    Args:
        sim: the simulation.
        addition: the objects.
        late: they may wait for the compile (`scene/editing/waiting`).
    """
    scene = sim.scene
    first = scene.next_handle
    prefix = f"{first}{GRAFT_END}"
    names = _names(sim, addition)
    part = addition.part
    if not isinstance(part, Straight):
        strip(part)

    def surgery(spec: mujoco.MjSpec) -> None:
        if isinstance(part, Straight):
            part.add_to(spec, prefix)
        elif addition.copies:
            Copier(lambda name: prefix + name, references=True).everything(part, spec)
        else:
            join(part, spec, prefix)

    added = Addition(
        prefix=prefix,
        names={(kind, prefix + name): names[old] for (kind, name), old in addition.names.items()},
        annotations={names[old]: renamed(note, names) for old, note in addition.annotations.items()},
        copies=addition.copies,
        hidden=frozenset(prefix + name for name in addition.hidden),
        registered={
            kind: {names[name]: renamed_registered(note, names) for name, note in notes.items()}
            for kind, notes in addition.registered.items()
        },
        start=addition.start.renamed(prefix),
    )
    moved = {(array, prefix + name) for array, name in addition.moved}
    welded = {prefix + name for name in addition.welded}
    weightless = {prefix + name for name in addition.weightless}
    weight = _weight(sim, addition)
    template = None
    if late and weight is not None and may_add(sim, added):
        template = addition.template()
    if weight is not None and template is not None and template.fits(added, scene.annotations):
        add_objects(sim, Late(template, surgery, weight, added, moved, welded, weightless))
    else:
        edit(
            sim,
            surgery,
            moved,
            welded=scene.welded_bodies | welded,
            weightless=scene.weightless_bodies | weightless,
            added=added,
            repeats=weight,
        )
    if addition.copies and scene.withheld:
        geoms = part.leaves["geom"] if isinstance(part, Straight) else {geom.name for geom in part.geoms}
        for (name, array), value in list(scene.withheld.items()):
            if name in geoms:
                sim.scene.withheld[prefix + name, array] = value
    objects = sim.scene.objects
    new = takewhile(lambda handle: handle >= first, reversed(objects))
    handles = {(objects[handle].element, objects[handle].element_name): handle for handle in new}
    return {
        (kind, name): handles[kind, prefix + name]
        for kind, name in addition.names
        if (kind, prefix + name) in handles
    }


def _weight(sim: Simulation, addition: Graft) -> float | None:
    """Return how much is added, as a number of bodies; None if it should not be added again to another copy."""
    part = addition.part
    if isinstance(part, Straight):
        return part.weight
    return len(part.bodies) if addition.copies else weight_of(part, sim.scene.blueprint.base)


def _names(sim: Simulation, addition: Graft) -> dict[str, str]:
    """Return the new name of each added object: all copy numbers rise alike, as in V-REP."""
    wanted = {*addition.names.values(), *(name for kind in addition.registered.values() for name in kind)}
    taken: Collection[str] = sim.scene.by_names().keys()
    if addition.registered:
        taken = taken | {name for names in sim.parts.registered_names().values() for name in names}
    return copy_names(wanted, taken)
