"""What `simxSetModelProperty` says of a model, and what becomes of it.

Bits of a model base restrict every object below it, as in V-REP, whatever its own properties are. Here they are put to
work that concern physics and start and stop; sensors ask `Scene.overridden` when they measure.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scene.objects import NOT_A_MODEL, ObjectKind

if TYPE_CHECKING:
    from simx_server.simulation import Simulation

SCRIPTS_INACTIVE = 0x200
"""`sim_modelproperty_scripts_inactive`, which the legacy constants lack."""

_NOT_SHOWN_INSIDE = 0x400
"""`sim_modelproperty_not_showasinsidemodel`, another: a matter of the hierarchy's display."""

_REFUSED = {c.sim_modelproperty_not_dynamic: "not_dynamic"}
_KNOWN = 0x1FF | SCRIPTS_INACTIVE | _NOT_SHOWN_INSIDE


def set_model_property(sim: Simulation, handle: int, bits: int) -> None:
    """Make an object a model base with these bits; with any bit of 0xF000, a model base no more.

    Raises UnknownHandle, CommandError for bits that mean nothing here.
    """
    item = sim.scene.get(handle)
    if bits & NOT_A_MODEL:
        sim.scene.model_properties[handle] = NOT_A_MODEL
    else:
        refused = [name for bit, name in _REFUSED.items() if bits & bit]
        if refused or bits & ~_KNOWN:
            raise CommandError(
                f"'{item.name}' cannot be a model with property 0x{bits & 0xFFFFFFFF:x}; "
                f"valid are the bits 0x{_KNOWN & ~sum(_REFUSED):x}, and 0x{NOT_A_MODEL:x} for no model"
            )
        sim.scene.model_properties[handle] = bits
    mute(sim)
    sim.changed()


def mute(sim: Simulation) -> None:
    """Keep the geoms of models that are not respondable from colliding, and give the others their collisions back."""
    scene, model = sim.scene, sim.model
    restricted = {
        handle
        for handle in scene.of_kind(ObjectKind.SHAPE)
        if scene.overridden(handle) & c.sim_modelproperty_not_respondable
    }
    for geom in range(model.ngeom):
        name = model.geom(geom).name
        wanted = scene.owner_of_geom(geom, model) in restricted
        if wanted and name not in scene.muted_geoms:
            scene.muted_geoms[name] = int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])
            model.geom_contype[geom] = model.geom_conaffinity[geom] = 0
        elif not wanted and name in scene.muted_geoms:
            model.geom_contype[geom], model.geom_conaffinity[geom] = scene.muted_geoms.pop(name)
    sim.model_edited()
