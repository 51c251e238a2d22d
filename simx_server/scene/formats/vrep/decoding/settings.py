"""Settings of the scene, textures, thumbnail."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import Engine, Settings, Texture

from .numbers import as_typed, color, vector

RGBA = 1
THUMBNAIL = 128
"""Pixels along a side."""

STEPS = {
    Engine.BULLET: ("BuN", "Bul"),
    Engine.ODE: ("OdN", "Ode"),
    Engine.VORTEX: ("Vo5", ""),
    Engine.NEWTON: ("Nw1", ""),
}
"""Records whose first real number is an engine's dynamics step, up to CoppeliaSim 4.4: newer and older one."""


ENGINE_TAGS = ("En3", "En2", "Eng")
"""Records of which the first one that a scene has tells its engine and gravity."""

NEWER_BULLET = 283

USUAL_STEPS = (0.2, 0.1, 0.05, 0.025, 0.01)
"""Simulation steps in seconds that V-REP's list offered, by number; the next number is that of a custom one."""
CUSTOM_STEP = len(USUAL_STEPS)


def fill_simulation(settings: Settings, chunks: Chunks) -> None:
    """Take over the time step and real time."""
    step = settings.time_step
    if chunks.has("St3"):
        (step,) = chunks.reals("St3", step)
    elif chunks.has("St2"):
        step = chunks.ints("St2")[0] / 1e6
    else:
        (step,) = chunks.reals("Sts", step)
    if 0 < step <= 10:
        settings.time_step = as_typed(step)
    else:
        chunks.note("Sts", f"has the time step {step} s; {settings.time_step} s is taken")
    (choice,) = chunks.ints("Spi", CUSTOM_STEP)
    if 0 <= choice < len(USUAL_STEPS):
        settings.time_step, settings.has_custom_step = USUAL_STEPS[choice], False
    (flags,) = chunks.ints("Ss2", 0)
    settings.is_real_time = bool(flags & 1)


def fill_dynamics(settings: Settings, chunks: Chunks) -> None:
    """Take over the engine, its step, and gravity."""
    tag = next((each for each in ENGINE_TAGS if chunks.has(each)), ENGINE_TAGS[0])
    engine, _ = chunks.ints(tag, 0, 0)
    if engine in Engine.__members__.values():
        settings.engine = Engine(engine)
    else:
        chunks.note(tag, f"names the unknown engine {engine}; Bullet is taken")
    settings.has_newer_bullet = chunks.ints("Ver", 0)[0] == NEWER_BULLET
    settings.gravity = vector([as_typed(part) for part in chunks.reals(tag, *settings.gravity)])
    (flags,) = chunks.ints("Var", 1)
    settings.dynamics = bool(flags & 1)
    step = _physics_step(settings, chunks)
    if 0 < step <= 10:
        settings.physics_step = as_typed(step)


def _physics_step(settings: Settings, chunks: Chunks) -> float:
    if chunks.has("Stp"):
        return chunks.reals("Stp", settings.physics_step)[0]
    newer, older = STEPS.get(settings.engine, STEPS[Engine.BULLET])
    if (values := chunks.array(newer)) is not None and values[0]:
        return values[0][0]
    return chunks.reals(older, settings.physics_step)[0] if older else settings.physics_step


def fill_environment(settings: Settings, chunks: Chunks) -> None:
    """Take over background, ambient light, layers, credits."""
    up, down = settings.background
    settings.background = color(chunks.reals("Clc", *up)), color(chunks.reals("Cld", *down))
    if chunks.has("Al2"):
        settings.ambient = color(chunks.reals("Al2", *settings.ambient))
    elif chunks.has("Alc"):  # older files: half of it
        settings.ambient = color([2 * part for part in chunks.reals("Alc", 0.2, 0.2, 0.2)])
    settings.fog = color(chunks.reals("Fbg", *settings.fog))
    settings.acknowledgement = chunks.text("Ack")
    (settings.visible_layers,) = chunks.ints("Vil", settings.visible_layers)


def texture_of(chunks: Chunks) -> Texture:
    """Return a texture. Raises SceneError."""
    number, width, height = chunks.ints("Ipa")
    (flags,) = chunks.ints("Bst", 0)
    channels = 4 if flags & RGBA else 3
    data = chunks.raw("Img")
    if width < 1 or height < 1 or width * height * channels != len(data):
        raise chunks.error("Img", f"has {len(data)} bytes for {width} x {height} pixels of {channels} bytes")
    pixels = np.frombuffer(data, np.uint8).reshape(height, width, channels).copy()
    return Texture(id=number, pixels=pixels)


def thumbnail_of(chunks: Chunks) -> NDArray[np.uint8] | None:
    """Return (128, 128, 3), None where it is stored in an unknown way.

    The second byte tells how: 0, four bytes of each pixel; 1, four bits of each colour, the low half of a byte first.
    """
    data = np.frombuffer(chunks.raw("Tm2"), np.uint8)
    pixels = THUMBNAIL * THUMBNAIL
    if data.size == 2 + 4 * pixels and data[1] == 0:
        return data[2:].reshape(THUMBNAIL, THUMBNAIL, 4)[:, :, :3].copy()
    if data.size == 2 + 3 * pixels // 2 and data[1] == 1:
        halves = np.stack((data[2:] & 15, data[2:] >> 4), axis=1)
        return (halves * 17).astype(np.uint8).reshape(THUMBNAIL, THUMBNAIL, 3)
    return None
