"""Parameters of a shape's contacts, and their records: of the engine that the file chooses.

In other engines than MuJoCo the friction of a shape counts together with that of the ground; see
`conversion/geometry/surfaces.py`. Only the friction is written for them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_server.editing import shape_looks
from simx_server.scene.formats.vrep.conversion.geometry.surfaces import Contact, Surfaces
from simx_server.scene.formats.vrep.decoding.colors import SURFACE_TAGS
from simx_server.scene.formats.vrep.objects import Engine, Shape, Surface
from simx_server.scene.formats.vrep.writing.record_lists import RecordList

from ..field import NotInVrepFiles, Writing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

Numbers = tuple[float, ...]

_NAMES = ("friction", "solref", "solimp", "solmix", "margin", "gap", "condim", "priority")
"""Columns of a contact, of which the first one is the sliding friction."""

_USUAL_SOLIMP = (0.9, 0.95, 0.001, 0.5, 2.0)

_FRICTIONS: Mapping[Engine, tuple[int, ...]] = {
    Engine.BULLET: (1, 2),
    Engine.ODE: (0,),
    Engine.VORTEX: (0,),
    Engine.NEWTON: (0, 1),
}
"""Places of the friction in an engine's real numbers: Bullet has two for its versions, Newton for rest and motion."""


def contacts(world: World, handle: int) -> tuple[Numbers, ...]:
    """Return the parameters of each geom of a shape that collides."""
    model = world.simulation.model
    return tuple(
        tuple(np.concatenate([np.ravel(getattr(model, f"geom_{name}")[geom]) for name in _NAMES]).tolist())
        for geom in shape_looks.geoms_of(world, handle)
        if model.geom_contype[geom] or model.geom_conaffinity[geom]
    )


def put_contacts(records: ObjectRecords, found: tuple[Numbers, ...], writing: Writing) -> None:
    """Write them. Raises NotInVrepFiles: the engine of the file has no such parameter, or no record for them."""
    surfaces = writing.surfaces
    if surfaces is None or not records.own.has("Mat"):
        raise NotInVrepFiles("parameters of contacts in a file of V-REP 3.3 or older")
    if len(set(found)) != 1:
        raise NotInVrepFiles("contacts that differ within a shape")
    with records.own.child("Mat") as material:
        if surfaces.engine == Engine.MUJOCO:
            _put_mujoco(material, found[0])
        else:
            _put_friction(material, found[0], surfaces)


def _put_mujoco(material: RecordList, now: Numbers) -> None:
    tag = SURFACE_TAGS[Engine.MUJOCO]
    reals, wholes = material.array(tag) or ([], [])
    (gap,) = now[12:13]
    if len(reals) < 12 or len(wholes) < 2 or gap:
        raise NotInVrepFiles("parameters of contacts for which the file has no record")
    material.put_array(tag, [*now[:12], *reals[12:]], [int(now[13]), int(now[14]), *wholes[2:]])


def _put_friction(material: RecordList, now: Numbers, surfaces: Surfaces) -> None:
    engines = {
        engine: values for engine, tag in SURFACE_TAGS.items() if (values := material.array(tag)) is not None
    }
    before = _row(surfaces.contact_of(Shape(handle=0, surface=Surface(engines=engines))))
    if not np.allclose(now[1:12], before[1:12]):
        raise NotInVrepFiles("parameters of contacts that only MuJoCo has")
    ground, _ = surfaces.ground
    engine = surfaces.engine if surfaces.engine in engines else Engine.BULLET
    if ground <= 0 or engine not in engines:
        raise NotInVrepFiles("a friction on a ground without friction")
    reals, wholes = engines[engine]
    for place in _FRICTIONS[engine]:
        if place < len(reals):
            reals[place] = now[0] / ground
    material.put_array(SURFACE_TAGS[engine], reals, wholes)


def _row(contact: Contact) -> Numbers:
    """Return a contact as the columns of a geom."""
    solimp = contact.solimp or _USUAL_SOLIMP
    return (
        *(*contact.friction, *contact.solref, *solimp, contact.solmix, contact.margin, 0.0),
        *(contact.condim, contact.priority),
    )


def keeps_contacts(now: Mapping[str, Any], before: Mapping[str, Any]) -> bool:
    """Return whether the file's parameters of contacts must be those of the shape.

    They follow from the file for a shape that did not collide, and a shape of another form has those of one part.
    """
    name = "parameters of contacts"
    return bool(now[name] and before[name]) and now["form"] == before["form"]
