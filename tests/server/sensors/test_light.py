"""The colour of a surface: what V-REP's use of OpenGL's fixed functions gives, beside what both renderers draw."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from both_renderers import make_renderer, opengl_name
from camera_world import load

from simx_server.scene.cameras.image import CameraView

__all__ = ["make_renderer", "opengl_name"]

DOWN = CameraView(
    camera_id=0, width=31, height=31, fovy_deg=20.0, near=0.1, far=10.0, background=(0.8, 0.9, 0.4)
)
AMBIENT = 0.4
LIGHTS = (((-0.8949, 0.3755, -0.2411), 0.4, 0.9), ((0.6, 0.0, -0.8), 0.5, 0.6), ((0.0, 0.0, -1.0), 0.2, 0.36))
"""Direction, diffuse and specular light: two of V-REP's default scene, and one from the side."""

SCENE = """
<mujoco>
  <visual><headlight ambient="{ambient} {ambient} {ambient}" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset><material name="look" rgba="{rgba}" specular="{mean}" shininess="{share}" emission="{emission}"/></asset>
  <worldbody>
    {lights}
    <geom type="box" size="1 1 0.01" euler="{euler}" material="look"/>
    <camera name="eye" pos="0 0 3"/>
  </worldbody>
  <custom><numeric name="simx:specular:look" data="{specular}"/></custom>
</mujoco>
"""


@dataclass(frozen=True)
class Look:
    """A material as V-REP has it."""

    diffuse: tuple[float, float, float]
    specular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shininess: int = 48
    glow: float = 0.0
    """Emission as a share of the diffuse colour."""
    opacity: float = 1.0


LOOKS = {
    "grey cover of a robot": Look((0.46, 0.46, 0.46), (0.3, 0.3, 0.3)),
    "red with golden highlights": Look((0.67, 0.21, 0.21), (0.8, 0.6, 0.1), 20),
    "metal that glows": Look((0.4, 0.4, 0.5), (0.5, 0.5, 0.5), 100, glow=0.5),
    "glass": Look((0.2, 0.5, 0.9), (0.25, 0.25, 0.25), opacity=0.3),
}


def scene_of(look: Look, turn_deg: float) -> str:
    lights = "".join(
        f'<light type="directional" castshadow="false" dir="{x} {y} {z}" '
        f'diffuse="{d} {d} {d}" specular="{s} {s} {s}"/>'
        for (x, y, z), d, s in LIGHTS
    )
    return SCENE.format(
        ambient=AMBIENT,
        rgba=" ".join(map(str, (*look.diffuse, look.opacity))),
        mean=sum(look.specular) / 3,
        share=look.shininess / 128,
        emission=look.glow,
        specular=" ".join(map(str, look.specular)),
        euler=f"0 {turn_deg} 0",
        lights=lights,
    )


def by_the_formula(look: Look, turn_deg: float) -> np.ndarray:
    """Return RGB 0..255 of a plate that is turned about y, seen from above."""
    normal = np.array((math.sin(math.radians(turn_deg)), 0.0, math.cos(math.radians(turn_deg))))
    diffuse = np.array(look.diffuse)
    colour = look.glow * diffuse + AMBIENT * diffuse
    for direction, strength, specular in LIGHTS:
        towards = -np.array(direction) / np.linalg.norm(direction)
        incidence = float(normal @ towards)
        if incidence > 0:
            halfway = towards + np.array((0.0, 0.0, 1.0))  # the eye is far away
            cosine = max(float(normal @ halfway) / float(np.linalg.norm(halfway)), 0.0)
            colour = colour + strength * incidence * diffuse
            colour = colour + specular * np.array(look.specular) * cosine**look.shininess
    colour = np.minimum(colour, 1.0)
    return 255 * (look.opacity * colour + (1 - look.opacity) * np.array(DOWN.background))


@pytest.mark.parametrize("name", LOOKS)
def test_a_surface_has_the_colour_of_v_reps_formula(make_renderer: Any, name: str) -> None:
    look = LOOKS[name]
    for turn_deg in (-40.0, -18.0, 0.0, 3.0, 35.0):
        model, data = load(scene_of(look, turn_deg))
        picture = make_renderer(model).render(data, DOWN, rgb=True, depth=False)
        for place in ((15, 15), (12, 20)):  # the same all over a flat surface
            assert picture.rgb[place] == pytest.approx(by_the_formula(look, turn_deg), abs=1.5), turn_deg


@pytest.mark.parametrize("left_out", range(8))
def test_components_of_light_are_left_out(
    make_renderer: Any, monkeypatch: pytest.MonkeyPatch, left_out: int
) -> None:
    look = Look((0.3, 0.5, 0.4), (0.6, 0.6, 0.6), 20, glow=0.25)
    model, data = load(scene_of(look, 3.0))
    view = dataclasses.replace(DOWN, unlit=left_out)
    picture = make_renderer(model).render(data, view, rgb=True, depth=False)
    ambient, diffuse, highlights = (not left_out & bit for bit in (1, 2, 4))
    monkeypatch.setitem(globals(), "AMBIENT", AMBIENT * ambient)
    monkeypatch.setitem(globals(), "LIGHTS", [(at, d * diffuse, s * highlights) for at, d, s in LIGHTS])
    assert picture.rgb[15, 15] == pytest.approx(by_the_formula(look, 3.0), abs=1.5)


@pytest.mark.parametrize(
    "form", ['type="sphere" size="1"', 'type="cylinder" size="1 0.5"', 'type="mesh" mesh="m"']
)
def test_highlights_have_their_colour_on_every_form(make_renderer: Any, form: str) -> None:
    look = Look((0.0, 0.0, 0.0), (1.0, 0.5, 0.0))
    xml = scene_of(look, 0).replace('type="box" size="1 1 0.01"', form)
    xml = xml.replace("<asset>", '<asset><mesh name="m" builtin="sphere" params="4"/>')
    model, data = load(xml)
    renderer = make_renderer(model)
    middle = renderer.render(data, DOWN, rgb=True, depth=False).rgb[15, 15].astype(int)
    assert middle[0] > 60
    assert abs(middle[1] - middle[0] / 2) <= 1
    assert middle[2] == 0
    model.numeric_data[:3] = (0.0, 0.5, 1.0)  # as scripts change it
    turned = renderer.render(data, DOWN, rgb=True, depth=False).rgb[15, 15].astype(int)
    assert turned == pytest.approx(middle[::-1], abs=1)


def test_a_light_that_is_not_white_colours_highlights_too(make_renderer: Any) -> None:
    look = Look((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))
    model, data = load(scene_of(look, 0))
    model.light_specular[:] = (1.0, 0.0, 0.5)
    rgb = make_renderer(model).render(data, DOWN, rgb=True, depth=False).rgb[15, 15].astype(int)
    assert rgb[0] > 100
    assert rgb[1] == 0
    assert abs(rgb[2] - rgb[0] / 2) <= 1
