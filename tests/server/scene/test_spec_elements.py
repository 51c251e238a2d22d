"""The elements of a spec are those of MuJoCo's own lists, in the same order."""

from __future__ import annotations

import mujoco
import pytest

from simx_server.files.library import find_scene, list_scenes
from simx_server.scene.spec_elements import bodies_of, leaves_of


@pytest.mark.parametrize("scene", list_scenes())
def test_elements_come_in_the_order_of_the_lists(scene: str) -> None:
    spec = mujoco.MjSpec.from_file(str(find_scene(scene)))
    assert [body.name for body in bodies_of(spec)] == [body.name for body in spec.bodies]
    for many in ("geoms", "sites", "joints", "cameras", "lights"):
        found = [(leaf.parent.name, leaf.name, str(leaf.info)) for leaf in leaves_of(spec, many)]
        assert found == [(leaf.parent.name, leaf.name, str(leaf.info)) for leaf in getattr(spec, many)]


def test_frames_and_later_elements_are_in_their_places() -> None:
    spec = mujoco.MjSpec.from_string(
        '<mujoco><worldbody><body name="a"><frame name="f" pos="1 0 0"><geom name="1" size="1"/></frame>'
        '<body name="b"><geom name="2" size="1"/></body></body><body name="c"/></worldbody></mujoco>'
    )
    spec.body("a").add_geom(name="3", size=[1, 0, 0])
    spec.worldbody.add_geom(name="4", size=[1, 0, 0])
    spec.body("a").add_body(name="d").add_geom(name="5", size=[1, 0, 0])
    assert [geom.name for geom in leaves_of(spec, "geoms")] == [geom.name for geom in spec.geoms]
    assert [body.name for body in bodies_of(spec)] == [body.name for body in spec.bodies]
    assert (
        [frame.name for frame in leaves_of(spec, "frames")] == ["f"] == [frame.name for frame in spec.frames]
    )
