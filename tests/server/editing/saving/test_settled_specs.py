"""A spec takes over what commands have written into the model, and elements get other names with all references."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from simx_server.scene.editing.saving.naming import rename_elements
from simx_server.scene.editing.saving.settling import settle
from simx_server.scene.formats.exporting.check import differing_arrays
from simx_server.scene.formats.loader import prepare

_FRAMED = """<mujoco><compiler angle="radian"/>
  <asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
  <worldbody>
    <frame pos="1 2 3" euler="0.1 0.2 0.3"><frame pos="0.5 0 0" quat="0.6 0 0.8 0">
      <body name="b" pos="0.1 0.2 0.3" quat="0.8 0.6 0 0">
        <joint name="j" axis="0 1 0" pos="0.1 0 0" range="-1 1" limited="true"/>
        <frame pos="0 0 1" euler="0.3 0 0">
          <geom name="g" type="box" size="0.1 0.2 0.3"/><geom name="m" type="mesh" mesh="wedge" pos="0.2 0 0"/>
          <geom name="c" type="capsule" size="0.1" fromto="0 0 0 0.3 0.4 0"/>
          <site name="s" pos="0.1 0 0"/><camera name="e" pos="0 0 1"/><light name="l" dir="0 0.6 -0.8"/>
        </frame>
      </body>
    </frame></frame>
  </worldbody></mujoco>"""


def turned(quat: np.ndarray) -> np.ndarray:
    return np.roll(quat, 1) / np.linalg.norm(quat)


def test_poses_within_frames_and_of_meshes_are_settled() -> None:
    spec = mujoco.MjSpec.from_string(_FRAMED)
    prepare(spec)
    model = spec.copy().compile()
    for kind in ("body", "geom", "site", "cam"):
        first = 1 if kind == "body" else 0
        getattr(model, f"{kind}_pos")[first:] += (0.25, -0.5, 0.125)
        for index in range(first, len(getattr(model, f"{kind}_pos"))):
            getattr(model, f"{kind}_quat")[index] = turned(getattr(model, f"{kind}_quat")[index] + 0.1)
    model.light_pos[:] += 0.5
    model.light_dir[:] = (0.6, 0, 0.8)
    model.light_attenuation[:], model.light_castshadow[:] = (0.5, 0.25, 0.125), False
    model.jnt_pos[:], model.jnt_axis[:] = (0.3, 0.4, 0), (0.6, 0, 0.8)
    model.jnt_range[:], model.dof_damping[:] = (-0.5, 2), 0.75
    model.geom_rgba[:], model.geom_size[0] = (0.25, 0.5, 0.75, 1), (0.5, 0.25, 0.125)
    mass = model.body_mass.copy()
    model.body_mass[1], model.body_inertia[1] = 3, (0.5, 0.4, 0.3)
    assert settle(spec, spec.copy().compile(), model, withheld={}, weightless=())
    found = spec.compile()
    for name in (
        "body_pos",
        "body_quat",
        "geom_pos",
        "geom_quat",
        "site_pos",
        "site_quat",
        "cam_pos",
        "cam_quat",
    ):
        assert np.allclose(getattr(found, name), getattr(model, name), atol=1e-12), name
    for name in (
        "light_pos",
        "light_dir",
        "light_attenuation",
        "light_castshadow",
        "jnt_pos",
        "jnt_axis",
        "jnt_range",
        "dof_damping",
    ):
        assert np.allclose(getattr(found, name), getattr(model, name), atol=1e-12), name
    for name in ("geom_rgba", "geom_size", "body_mass", "body_inertia", "body_ipos"):
        assert np.allclose(getattr(found, name), getattr(model, name), atol=1e-12), name
    assert found.body_mass[1] != mass[1]


def test_numbers_that_no_command_has_written_stay_those_of_the_spec() -> None:
    spec = mujoco.MjSpec.from_string(_FRAMED)
    before = spec.copy().compile()
    assert not settle(spec, spec.copy().compile(), before, withheld={}, weightless=())
    assert differing_arrays(before, spec.compile()) == []


def test_numbers_that_a_property_of_a_model_replaces_are_those_of_the_geom() -> None:
    spec = mujoco.MjSpec.from_string(_FRAMED)
    model = spec.copy().compile()
    model.geom_group[0] = 5
    settle(spec, spec.copy().compile(), model, withheld={("g", "geom_group"): 2}, weightless=("b",))
    assert spec.geom("g").group == 2


def test_all_that_refers_to_an_element_refers_to_its_new_name() -> None:
    spec = mujoco.MjSpec.from_string("""<mujoco><worldbody>
        <site name="far" pos="2 0 0"/>
        <body name="a"><joint name="j"/><geom name="g" size="0.1"/><site name="s"/>
          <body name="b" pos="0 0 1"><joint name="k"/><geom name="h" size="0.1"/><site name="t"/></body></body>
        <camera name="eye" mode="targetbody" target="a"/></worldbody>
      <tendon><spatial name="rope"><site site="s"/><geom geom="h" sidesite="t"/><site site="far"/></spatial>
        <fixed name="gear"><joint joint="j" coef="2"/><joint joint="k" coef="-1"/></fixed></tendon>
      <actuator><motor name="m" joint="j"/><motor name="n" tendon="rope"/></actuator>
      <sensor><force site="s"/><jointpos joint="k"/><tendonpos tendon="gear"/></sensor>
      <equality><weld body1="a" body2="b"/><joint joint1="j" joint2="k"/><connect site1="s" site2="t"/></equality>
      <contact><exclude body1="a" body2="b"/><pair geom1="g" geom2="h"/></contact></mujoco>""")
    before = spec.copy().compile()
    new = {
        **{("body", name): f"body {name}" for name in "ab"},
        ("joint", "j"): "k",
        ("joint", "k"): "j",
        **{("geom", name): f"geom {name}" for name in "gh"},
        **{("site", name): f"site {name}" for name in ("s", "t", "far")},
        ("tendon", "rope"): "gear",
        ("tendon", "gear"): "rope",
    }
    assert rename_elements(spec, new)
    after = spec.compile()
    assert [name for name in differing_arrays(before, after) if name != "signature"] == []
    assert [after.joint(index).name for index in range(2)] == ["k", "j"]
    assert after.tendon(0).name == "gear"


def test_an_element_without_an_object_makes_room_for_a_name() -> None:
    spec = mujoco.MjSpec.from_string(
        '<mujoco><worldbody><body name="a"/><body name="b"><geom name="g" size="1"/></body></worldbody></mujoco>'
    )
    rename_elements(spec, {("body", "b"): "a"})
    assert [body.name for body in spec.bodies] == ["world", "~a_1", "a"]


@pytest.mark.parametrize("names", [{}, {("body", "b"): "b"}])
def test_names_that_stay_need_no_work(names: dict[tuple[str, str], str]) -> None:
    spec = mujoco.MjSpec.from_string('<mujoco><worldbody><body name="b"/></worldbody></mujoco>')
    assert not rename_elements(spec, names)
