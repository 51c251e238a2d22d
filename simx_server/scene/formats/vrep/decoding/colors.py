"""Lists of colours, and parameters of contacts per physics engine."""

from __future__ import annotations

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import Engine, Material, Surface

from .numbers import color

OPAQUE = 4


def material_of(chunks: Chunks | None) -> Material:
    """Return the colours in a list of colours; the default ones where there is none."""
    material = Material()
    if chunks is None:
        return material
    material.name = chunks.text("Cnm")
    if chunks.has("Cl3"):
        values = chunks.reals("Cl3", *(0.5,) * 15)
    else:  # of an older gamma, in which the ambient colour was added
        tag = "Cl2" if chunks.has("Cl2") else "Cls"
        values = chunks.reals(tag, *(0.5,) * (15 if tag == "Cl2" else 12))
        ambient = sum(values[3:6]) / 3
        diffuse = [(value + 0.5 * ambient) / 0.85 for value in values[:3]]
        brightest = max(1.0, *diffuse)
        # V-REP takes the mean for the colour of a light, too.
        values = (*(value / brightest for value in diffuse), ambient, ambient, ambient, *values[6:])
    material.diffuse, material.light = color(values), color(values[3:])
    material.specular, material.emission = color(values[6:]), color(values[9:])
    (flags,) = chunks.ints("Var", OPAQUE)
    if not flags & OPAQUE:
        (opacity,) = chunks.reals("Trf", 1.0)
        material.opacity = min(max(opacity, 0.0), 1.0)
    (material.shininess,) = chunks.ints("Sh2", material.shininess)
    return material


SURFACE_TAGS = {
    Engine.BULLET: "BuN",
    Engine.ODE: "OdN",
    Engine.VORTEX: "Vo4",
    Engine.NEWTON: "Nw1",
    Engine.MUJOCO: "Mj1",
}


def surface_of(chunks: Chunks) -> Surface:
    """Return the parameters of contacts in a list of materials."""
    surface = Surface(name=chunks.text("Gon"))
    for engine, tag in SURFACE_TAGS.items():
        if (values := chunks.array(tag)) is not None:
            surface.engines[engine] = values
    if Engine.BULLET not in surface.engines and chunks.has("Bul"):
        restitution, friction, *dampings = chunks.reals("Bul", 0.0, 0.5, 0.0, 0.0)
        # In the order of the newer record, which has two frictions.
        surface.engines[Engine.BULLET] = ([restitution, friction, friction, *dampings], [])
    if Engine.ODE not in surface.engines and chunks.has("Od2"):
        ints, reals = chunks.ints("Od2", 64), chunks.reals("Od2", 1.0, 0.2, 0.0, 0.0, 0.0)
        surface.engines[Engine.ODE] = (list(reals), list(ints))
    return surface
