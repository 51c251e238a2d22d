"""Properties of dummies, lights and script objects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.constant_tables import TABLES
from simx_server.errors import CommandError
from simx_server.scene.editing import editing
from simx_server.scene.geometry import lights
from simx_server.scripting.script import Order, Script
from simx_server.sim_api.properties.entry import Property, numbered, renamed
from simx_server.sim_api.properties.property_types import BOOL, COLOR, FLOAT, FLOAT_ARRAY, HANDLE, INT, STRING

if TYPE_CHECKING:
    from simx_server.world.world import World

_LINKED = Property(
    "linkedDummy",
    HANDLE,
    lambda world, handle: world.dummy_links.linked(handle),
    lambda world, handle, other: world.dummy_links.link(handle, other),
)


def _dummy_color(name: str, component: int) -> Property:
    return Property(
        name, COLOR, lambda world, handle: editing.dummy_color(world.simulation, handle, component)
    )


_NO_LINK = TABLES["dummytype_default"]


def _dummy_type(world: World, handle: int) -> int:
    """Return `sim.dummytype_*`; a dummy without a link has CoppeliaSim's default type."""
    kind, is_linked = world.dummy_links.type(handle), world.dummy_links.linked(handle) != -1
    return kind if kind or is_linked else _NO_LINK


DUMMIES = (
    numbered("dummySize", FLOAT, "dummyfloatparam_size"),
    _LINKED,
    renamed(_LINKED, "linkedDummyHandle", INT),
    Property(
        "dummyType",
        INT,
        _dummy_type,
        lambda world, handle, kind: world.dummy_links.set_type(handle, kind),
    ),
    _dummy_color("color.diffuse", 1),
    _dummy_color("color.specular", 2),
    _dummy_color("color.emission", 3),
)


def _light_type(world: World, handle: int) -> int:
    if lights.is_directional(world.simulation, handle):
        return c.sim_light_directional_subtype
    if lights.is_omnidirectional(world.simulation, handle):
        return c.sim_light_omnidirectional_subtype
    return c.sim_light_spot_subtype


def _switch_light(world: World, handle: int, on: bool) -> None:
    lights.set_light(world.simulation, handle, on)


def _light_color(name: str, place: int) -> Property:
    def put(world: World, handle: int, color: list[float]) -> None:
        on, diffuse, specular = lights.light(world.simulation, handle)
        both = [diffuse, specular]
        both[place] = color
        lights.set_light(world.simulation, handle, on, *both)

    return Property(name, COLOR, lambda world, handle: lights.light(world.simulation, handle)[1 + place], put)


def _set_attenuation(world: World, handle: int, factors: list[float]) -> None:
    if len(factors) != 3 or min(factors) < 0 or not any(factors):
        raise CommandError(
            "'attenuationFactors' is {constant, linear, quadratic}, none below 0 and one above"
        )
    sim = world.simulation
    sim.model.light_attenuation[sim.scene.get(handle).id] = factors
    sim.model_edited()
    sim.changed()


LIGHTS = (
    Property("enabled", BOOL, lambda world, handle: lights.light(world.simulation, handle)[0], _switch_light),
    Property("lightType", INT, _light_type),
    numbered("spotExponent", INT, "lightfloatparam_spot_exponent"),
    numbered("spotCutoffAngle", FLOAT, "lightfloatparam_spot_cutoff"),
    Property(
        "attenuationFactors",
        FLOAT_ARRAY,
        lambda world, handle: world.simulation.model.light_attenuation[
            world.simulation.scene.get(handle).id
        ].tolist(),
        _set_attenuation,
    ),
    numbered("povray.castShadows", BOOL, "lightintparam_pov_casts_shadows"),
    _light_color("color.diffuse", 0),
    _light_color("color.specular", 1),
)


def _script(world: World, handle: int) -> Script:
    found = next((one for one in world.scripts.all() if one.place == handle), None)
    if found is None:
        name = world.simulation.scene.get(handle).name
        raise CommandError(f"script object '{name}' has no script: it was removed")
    return found


def _set_order(world: World, handle: int, order: int) -> None:
    if order not in tuple(Order):
        raise CommandError(f"the execution priority of a script is 0 first, 1 normal or 2 last, not {order}")
    world.scripts.set_order(_script(world, handle), Order(order))


def _state(world: World, handle: int) -> int:
    """Return `sim.scriptstate_*`: 1 uninitialized, 2 initialized, 8 error."""
    script = _script(world, handle)
    return 8 if script.problem else 1 if script.interpreter is None else 2


def _code(world: World, handle: int) -> str:
    return _script(world, handle).source(world.simulation).decode("utf-8", "surrogateescape")


SCRIPTS = (
    Property(
        "scriptDisabled",
        BOOL,
        lambda world, handle: not _script(world, handle).is_enabled,
        lambda world, handle, disabled: world.scripts.enable(_script(world, handle), not disabled),
    ),
    Property("execPriority", INT, lambda world, handle: int(_script(world, handle).order), _set_order),
    Property("scriptType", INT, lambda world, handle: int(_script(world, handle).kind)),
    Property("scriptState", INT, _state),
    Property("language", STRING, lambda world, handle: _script(world, handle).language),
    Property("code", STRING, _code, is_large=True),
    Property("scriptName", STRING, lambda world, handle: world.scripts.describe(_script(world, handle))),
    Property("detachedScript", HANDLE, lambda world, handle: _script(world, handle).handle),
)
"""The text of a script belongs to the scene's files: it can be read, and not be changed."""
