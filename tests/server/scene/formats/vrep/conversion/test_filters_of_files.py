"""Filter chains of V-REP's files as chains of the scene."""

from __future__ import annotations

import math

import pytest
from conversions import conversion_of, scene_of

from simx_server.scene.formats.texts.filter_chains import COMPONENTS, read_chain
from simx_server.scene.formats.vrep.conversion.sensing.filters import chain_text, is_plain, shows_depth
from simx_server.scene.formats.vrep.conversion.sensing.vision import add_vision
from simx_server.scene.formats.vrep.objects import Filter, VisionSensor
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.poses import IDENTITY
from simx_server.sensors.vision.vision_settings import VisionSettings, settings_from_model

BINARY = Filter(type=28, reals=[0.5, 0, 0, 0, 0.4, 0.25, 0.6, 0.3, 0.7, 0.2, 0.0, 1.571, 0.9], data=b"\x0c")


def sensor(*filters: Filter | int) -> VisionSensor:
    """A sensor with these filters; a number is a filter without values."""
    chain = [Filter(type=one) if isinstance(one, int) else one for one in filters]
    return VisionSensor(handle=1, name="eye", filters=chain)


def text(*filters: Filter | int) -> str:
    eye = sensor(*filters)
    conversion = conversion_of(eye)
    found = chain_text(conversion, eye)
    assert conversion.report.left_out == {}
    return found


def test_known_components_keep_their_values() -> None:
    assert text(1, BINARY, 4) == ("image|binary:0.5,0.4,0.25,0.6,0.3,0.7,0.2,0,1.571,0.9,yes|output")
    assert text(2, Filter(type=35, integers=[342, 1], data=b"\x00"), 4) == "depth|coordinates:342,1,no|output"
    assert (
        text(2, Filter(type=37, integers=[1000, 16, 0, 0], reals=[0.5, 0, 0])) == "depth|velodyne:1000,16,0.5"
    )
    assert text(1, Filter(type=34, reals=[0.1, 0.02], data=b"\x01"), 4) == "image|blobs:0.1,0.02,yes|output"
    assert (
        text(1, Filter(type=15, reals=[math.pi]), 13, 4) == "image|rotate:3.14159265|flip_horizontally|output"
    )


def test_every_number_of_v_rep_but_one_is_a_component() -> None:
    names = set()
    for kind in range(1, 39):
        full = Filter(type=kind, integers=[2, 2, 2], reals=[0.5] * 26, data=b"\xff")
        eye = sensor(full)
        conversion = conversion_of(eye)
        found = chain_text(conversion, eye)
        if kind == 32:  # the correlation of two images, which nothing documents
            assert (found, len(conversion.report.left_out)) == ("none", 1)
        else:
            assert conversion.report.left_out == {}
            names.add(read_chain(found)[0].name)
    assert names == set(COMPONENTS)


def test_switches_whose_places_are_not_known_from_files_are_reported() -> None:
    eye = sensor(1, Filter(type=25, reals=[0.0, 1.0], data=b"\x01"), 4)
    conversion = conversion_of(eye)
    assert chain_text(conversion, eye) == "image|intensity_scale:0,1,yes|output"
    assert list(conversion.report.approximated.values()) == [["eye"]]
    assert text(1, BINARY)


def test_disabled_components_do_nothing() -> None:
    assert text(1, Filter(type=13, enabled=False), 14, 4) == "image|flip_vertically|output"
    assert is_plain(sensor(1, Filter(type=13, enabled=False), 4))


@pytest.mark.parametrize(
    "damaged",
    [
        Filter(type=15),
        Filter(type=15, reals=[math.nan]),
        Filter(type=35, integers=[2_000_000_000, -1]),
        Filter(type=35, integers=[1000, 1001]),
        Filter(type=1001),
        Filter(type=-1),
    ],
    ids=["no value", "nan", "negative count", "too many points", "of a plug-in", "unknown"],
)
def test_unusable_component_is_left_out_and_named(damaged: Filter) -> None:
    eye = sensor(1, damaged, 4)
    conversion = conversion_of(eye)
    assert chain_text(conversion, eye) == "image|output"
    ((sentence, names),) = conversion.report.left_out.items()
    assert str(damaged.type) in sentence
    assert names == ["eye"]


def settings_of(eye: VisionSensor) -> VisionSettings:
    scene, model = scene_of(conversion_of(eye), add_vision, IDENTITY, eye)
    return settings_from_model(scene.objects[scene.of_kind(ObjectKind.VISION_SENSOR)[0]], model)


def test_usual_chains_need_no_filters() -> None:
    assert settings_of(sensor(1, 4)).chain is None
    assert settings_of(VisionSensor(handle=1, name="eye")).chain is None
    depth = settings_of(sensor(2, 4))
    assert depth.chain is None
    assert depth.shows_depth
    assert not settings_of(sensor(1, 4)).shows_depth
    assert not shows_depth(sensor(2))


def test_other_chains_are_applied() -> None:
    empty = settings_of(sensor())
    assert empty.chain is not None
    assert empty.chain.components == ()
    chain = settings_of(sensor(1, BINARY, 4)).chain
    assert chain is not None
    assert [component.name for component in chain.components] == ["image", "binary", "output"]


def test_sensor_of_one_pixel_has_one_pixel() -> None:
    eye = VisionSensor(handle=1, name="eye", resolution=(1, 1))
    assert (settings_of(eye).width, settings_of(eye).height) == (1, 1)
    assert settings_of(VisionSensor(handle=1, name="eye", resolution=(2, 1))).height == 1
