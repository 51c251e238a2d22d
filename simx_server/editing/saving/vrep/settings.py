"""Settings of a scene, and its custom data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.parts.custom_data import HIDDEN, SCENE
from simx_server.scene.formats.annotations.grammar import ENGINES
from simx_server.scene.formats.vrep.chunks import twin
from simx_server.scene.formats.vrep.decoding.settings import CUSTOM_STEP, ENGINE_TAGS, STEPS
from simx_server.scene.formats.vrep.objects import Engine
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list
from simx_server.scene.formats.vrep.writing.top_level import TopRecord

from .common import FIRST_WITH_TAGGED_DATA, replace_blocks
from .facts import Facts, are_equal
from .field import NotInVrepFiles

if TYPE_CHECKING:
    from simx_server.world.world import World

_WRITTEN = ("engine", "layers", "dynamics", "background")
"""Keys of the scene's annotation that are written."""


def settings_of(world: World) -> dict[str, Any]:
    """Return the settings of a world by name."""
    sim = world.simulation
    notes = sim.scene.annotations.scene
    return {
        "time step": sim.time_step,
        "physics step": sim.physics_step,
        "gravity": tuple(sim.model.opt.gravity.tolist()),
        "dynamics": sim.dynamics_enabled,
        "engine": str(notes.get("engine", "bullet")),
        "layers": world.object_settings.visible_layers,
        "fog": tuple(world.vision.background),
        "ambient light": tuple(sim.model.vis.headlight.ambient.tolist()),
    }


def data_of(world: World) -> dict[str, bytes]:
    """Return the custom data of the scene."""
    data = world.custom_data
    names = [name for name in data.names(SCENE) if not name.startswith((HIDDEN, "@tmp"))]
    return {name: content for name in names if (content := data.read(SCENE, name))}


def change_settings(records: list[TopRecord], facts: Facts, before: Facts, serialization: int) -> None:
    """Write the settings that differ into the records of a scene. Raises NotInVrepFiles."""
    new, old = settings_of(facts.world), settings_of(before.world)
    rest, old_rest = (
        {key: value for key, value in each.saved.settings.items() if key not in _WRITTEN}
        for each in (facts, before)
    )
    if rest != old_rest:
        keys = sorted(key for key in rest.keys() | old_rest.keys() if rest.get(key) != old_rest.get(key))
        raise NotInVrepFiles(f"the setting '{keys[0]}' of the scene")
    changed = {name: value for name, value in new.items() if not are_equal(value, old[name])}
    present = {tag for tag, _ in records}
    for name in changed:
        if present.isdisjoint(_RECORDS[name]):
            raise NotInVrepFiles(f"the {name} of the scene, for which the file has no record")
    for place, (tag, payload) in enumerate(records):
        if tag in _PUT and changed:
            found = parse_list(tag, payload, serialization)
            _PUT[tag](found, changed)
            records[place] = tag, bytes(found) + END
    if data_of(facts.world) != data_of(before.world):
        _change_data(records, data_of(facts.world), serialization)


def _put_simulation(found: RecordList, changed: dict[str, Any]) -> None:
    if "time step" not in changed:
        return
    step = changed["time step"]
    if found.has("St3") or found.has(twin("St3")):
        found.put_numbers("St3", step)
    if found.has("St2"):
        found.put_numbers("St2", round(step * 1e6))
    found.put_numbers("Sts", step)
    if found.has("Spi"):
        found.put_numbers("Spi", CUSTOM_STEP)


def _put_dynamics(found: RecordList, changed: dict[str, Any]) -> None:
    for tag in _engine_tags(found):
        engine = ENGINES.index(changed["engine"]) if "engine" in changed else None
        gravity = changed.get("gravity", (None, None, None))
        found.put_numbers(tag, engine, *gravity, None)
    if "dynamics" in changed:
        found.put_bits("Var", 1, int(changed["dynamics"]))
    if "physics step" in changed:
        _put_physics_step(found, changed["physics step"])


def _engine_tags(found: RecordList) -> list[str]:
    """Return the tags under which a scene has its engine and gravity."""
    return [tag for tag in ENGINE_TAGS if found.has(tag) or found.has(twin(tag))] or list(ENGINE_TAGS[:1])


def _put_physics_step(found: RecordList, step: float) -> None:
    if found.has("Stp") or found.has(twin("Stp")):
        found.put_numbers("Stp", step)
        return
    engine = int((found.numbers(_engine_tags(found)[0]) or [0])[0])
    known = Engine(engine) if engine in Engine.__members__.values() else Engine.BULLET
    newer, older = STEPS.get(known, STEPS[Engine.BULLET])
    if (values := found.array(newer)) is not None and values[0]:
        found.put_array(newer, [step, *values[0][1:]], values[1])
    elif older:
        found.put_numbers(older, step)


def _put_environment(found: RecordList, changed: dict[str, Any]) -> None:
    if "fog" in changed:
        found.put_numbers("Fbg", *changed["fog"])
    if "ambient light" in changed:
        found.put_numbers("Al2", *changed["ambient light"])
    if "layers" in changed and found.has("Vil"):
        found.put_numbers("Vil", changed["layers"])


def _put_layers(found: RecordList, changed: dict[str, Any]) -> None:
    if "layers" in changed:
        found.put_numbers("Al2", changed["layers"])


_RECORDS = {
    "time step": ("SIM",),
    **dict.fromkeys(("physics step", "gravity", "dynamics", "engine"), ("DYN",)),
    **dict.fromkeys(("fog", "ambient light"), ("ENV",)),
    "layers": ("SET", "ENV"),
}
"""Tags of the records that may have a setting."""

_PUT = {"SIM": _put_simulation, "DYN": _put_dynamics, "ENV": _put_environment, "SET": _put_layers}
"""Writers by the tag of the record."""


def _change_data(records: list[TopRecord], blocks: dict[str, bytes], serialization: int) -> None:
    """Replace the custom data of the scene that scripts have written."""
    present = [tag for tag, _ in records if tag in ("CDA", "CDS")]
    for tag in present or ["CDA" if serialization >= FIRST_WITH_TAGGED_DATA else "CDS"]:
        old = next((payload for each, payload in records if each == tag), END)
        found = parse_list(tag, old, serialization)
        replace_blocks(found, blocks, is_tagged=tag == "CDA")
        new = tag, bytes(found) + END
        place = next((at for at, (each, _) in enumerate(records) if each == tag), None)
        if place is None:
            records.append(new)
        else:
            records[place] = new
