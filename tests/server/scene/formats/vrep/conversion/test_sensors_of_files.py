"""Proximity and force sensors, cameras and lights of V-REP's files."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from conversions import conversion_of, scene_of
from numpy.testing import assert_allclose

from simx_server.scene.cameras.image import CameraView
from simx_server.scene.formats.vrep.conversion.context import collection_name
from simx_server.scene.formats.vrep.conversion.sensing.cameras import add_camera
from simx_server.scene.formats.vrep.conversion.sensing.force import add_force_sensor
from simx_server.scene.formats.vrep.conversion.sensing.inert import report_inert
from simx_server.scene.formats.vrep.conversion.sensing.lights import add_light, set_surroundings
from simx_server.scene.formats.vrep.conversion.sensing.proximity import add_proximity
from simx_server.scene.formats.vrep.conversion.sensing.vision import add_vision
from simx_server.scene.formats.vrep.objects import (
    Camera,
    Collection,
    Dummy,
    ForceSensor,
    Light,
    Material,
    OtherObject,
    ProximitySensor,
    Settings,
    VisionSensor,
    Volume,
)
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.poses import Pose
from simx_server.sensors.proximity.optics import Optics, optics
from simx_server.sensors.vision.vision_settings import VisionSettings, settings_from_model

pytestmark = pytest.mark.slow

TURNED: Pose = ((0.1, 0.2, 0.3), (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0))
"""A frame whose z is x of the body, and whose x is -z."""
GARBAGE = math.nan


def proximity_optics(**fields: object) -> tuple[Optics, dict[str, object]]:
    """The optics of a converted sensor, and its annotation."""
    sensor = ProximitySensor(handle=5, name="nose", **fields)  # type: ignore[arg-type]
    scene, _ = scene_of(conversion_of(sensor), add_proximity, TURNED, sensor)
    item = scene.objects[scene.of_kind(ObjectKind.PROXIMITY_SENSOR)[0]]
    note = item.annotations["proximity"]
    return optics(note, 10.0), dict(note)


def volume(kind: str, **sizes: float) -> Volume:
    """A volume whose unused fields hold what cannot be used."""
    unused = dict.fromkeys(
        ("x_size", "y_size", "x_size_far", "y_size_far", "radius", "radius_far", "angle"), GARBAGE
    )
    return Volume(type=kind, **{**unused, **sizes})  # type: ignore[arg-type]


def test_sensor_of_a_file_is_a_site_that_looks_along_its_z() -> None:
    sensor = ProximitySensor(
        handle=5, name="nose", method="cone", volume=volume("cone", angle=1.0, radius=0.0)
    )
    scene, model = scene_of(conversion_of(sensor), add_proximity, TURNED, sensor)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    assert scene.objects[scene.by_name("nose") or 0].kind is ObjectKind.PROXIMITY_SENSOR
    assert_allclose(data.site("nose").xpos, [1.1, 2.2, 3.3], atol=1e-9)
    assert_allclose(data.site("nose").xmat.reshape(3, 3)[:, 2], [1, 0, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("made", "inside", "outside"),
    [
        (volume("ray", range=2.0, offset=0.1), (0, 0, 2.05), (0, 0, 2.15)),
        (volume("cone", range=1.0, angle=1.0, radius=0.2), (0.3, 0, 0.9), (0, 0, 0.19)),
        (volume("cylinder", range=1.0, radius=0.1, radius_far=0.3), (0.19, 0, 0.5), (0.21, 0, 0.5)),
        (volume("cylinder", range=0.08, offset=-0.04, radius=0.05, radius_far=0.05), (0.04, 0, -0.03), (0, 0, 0.05)),
        (volume("pyramid", range=1.0, x_size=0.2, y_size=0.4, x_size_far=0.2, y_size_far=0.8),
         (0.09, 0.29, 0.5), (0.11, 0, 0.5)),
        (volume("disc", range=1.0, y_size=0.1, angle=1.5, radius=0.1), (0.3, 0.04, 0.5), (0.3, 0.06, 0.5)),
    ],
    ids=lambda value: value.type if isinstance(value, Volume) else "",
)  # fmt: skip
def test_volume_has_the_sizes_of_the_file(made: Volume, inside: object, outside: object) -> None:
    looks, _ = proximity_optics(method=made.type, volume=made)
    assert looks.kind == made.type
    assert (looks.offset, looks.reach) == (pytest.approx(made.offset), pytest.approx(made.range))
    if made.type != "ray":  # along which only a range counts
        assert looks.volume.contains(np.array(inside, float))
        assert not looks.volume.contains(np.array(outside, float))


def test_ray_method_in_a_cone_is_random_rays() -> None:
    looks, note = proximity_optics(
        method="ray", volume=volume("cone", angle=1.0, radius=0.1, inside_gap=0.5), rays=(20, 5)
    )
    throw = looks.throw
    assert throw is not None
    assert (throw.rays, throw.needed, throw.blind) == (20, 5, pytest.approx(0.1))
    assert (throw.least_angle, throw.greatest_angle) == (pytest.approx(0.25), pytest.approx(0.5))
    assert note["type"] == "random_rays"


def test_settings_of_a_sensor_go_over() -> None:
    looks, note = proximity_optics(
        volume=volume("ray"),
        minimum_distance=0.05,
        is_explicit=True,
        front_faces=False,
        max_normal_angle=math.radians(30),
        detectable_kind=0x40,
    )
    assert looks.least_distance == pytest.approx(0.05)
    assert looks.faces == "back"
    assert looks.least_cosine == pytest.approx(math.cos(math.radians(30)))
    assert looks.detects == "laser"
    assert note["explicit"] is True
    assert proximity_optics(volume=volume("ray"), front_faces=False, back_faces=False)[0].faces == "none"


def test_hopeless_numbers_make_a_sensor_that_detects_nothing_instead_of_a_failure() -> None:
    for kind in ("ray", "cone", "cylinder", "pyramid", "disc"):
        looks, _ = proximity_optics(method=kind, volume=volume(kind, offset=math.inf, range=math.nan))
        assert looks.reach < 1e-5


def test_entity_is_an_object_a_collection_or_with_an_unknown_number_everything() -> None:
    body = Dummy(handle=7, name="body")
    named = Collection(id=2_000_003, name="the robot")
    found = {}
    for entity in (7, 2_000_003, 2_020_001, -1):
        sensor = ProximitySensor(handle=5, name="nose", volume=volume("ray"), entity=entity)
        conversion = conversion_of(body, sensor, collections=[named])
        conversion.spec.worldbody.add_site(name="body")
        conversion.annotate("collection", collection_name(named), objects="body")
        scene, _ = scene_of(conversion, add_proximity, TURNED, sensor)
        note = scene.objects[scene.by_name("nose") or 0].annotations["proximity"]
        found[entity] = note.get("entity"), conversion.report.approximated
    assert found[7] == ("body", {})
    assert found[2_000_003] == ("collection:the_robot", {})
    assert found[-1] == (None, {})
    assert found[2_020_001][0] is None
    assert list(found[2_020_001][1].values()) == [["nose"]]


def test_force_sensor_measures_at_its_site_and_keeps_thresholds() -> None:
    sensor = ForceSensor(handle=3, name="cell", max_force=100.0, violations=10, samples=5, filter="median")
    scene, _ = scene_of(conversion_of(sensor), add_force_sensor, TURNED, sensor)
    item = scene.objects[scene.of_kind(ObjectKind.FORCE_SENSOR)[0]]
    assert item.name == "cell"
    assert len(item.sensors) == 2
    assert item.annotations["force"] == {
        "max_force": 100.0, "violations": 10, "samples": 5, "filter": "median",
    }  # fmt: skip


def test_force_sensor_that_only_triggers_and_one_that_never_breaks() -> None:
    notes = []
    for fields in ({"max_torque": 0.0, "breaks": False}, {"breaks": False}):
        sensor = ForceSensor(handle=3, name="cell", **fields)  # type: ignore[arg-type]
        scene, _ = scene_of(conversion_of(sensor), add_force_sensor, TURNED, sensor)
        notes.append(scene.objects[scene.of_kind(ObjectKind.FORCE_SENSOR)[0]].annotations["force"])
    assert notes[0]["overload"] == "trigger"
    assert 0 < float(notes[0]["max_torque"]) < 1e-6
    assert notes[1] == {"samples": 1}


def vision(**fields: object) -> tuple[VisionSettings, mujoco.MjModel]:
    """The settings of a converted vision sensor."""
    sensor = VisionSensor(handle=9, name="eye", **fields)  # type: ignore[arg-type]
    scene, model = scene_of(conversion_of(sensor), add_vision, TURNED, sensor)
    return settings_from_model(scene.objects[scene.of_kind(ObjectKind.VISION_SENSOR)[0]], model), model


def test_vision_sensor_looks_along_z_with_y_up() -> None:
    _, model = vision()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    right, up, backward = data.cam_xmat[0].reshape(3, 3).T
    assert_allclose(backward, [-1, 0, 0], atol=1e-9)
    assert_allclose(up, [0, 1, 0], atol=1e-9)
    assert_allclose(right, [0, 0, 1], atol=1e-9)  # V-REP's x, -z of the body, points to the left


@pytest.mark.parametrize("resolution", [(640, 480), (480, 640), (256, 1)])
def test_perspective_angle_belongs_to_the_larger_side(resolution: tuple[int, int]) -> None:
    settings, model = vision(resolution=resolution, angle=1.2, near=0.02, far=4.0)
    assert (settings.width, settings.height) == resolution
    assert settings.angle == pytest.approx(1.2)
    assert (settings.near, settings.far) == (0.02, 4.0)
    assert settings.orthographic_size is None
    # MuJoCo's own cameras agree, for programs that read the model.
    larger = max(resolution)
    half_height = math.tan(math.radians(float(model.cam_fovy[0])) / 2)
    assert half_height * larger / resolution[1] == pytest.approx(math.tan(0.6))


@pytest.mark.parametrize("resolution", [(64, 32), (32, 64)])
def test_orthographic_size_belongs_to_the_larger_side(resolution: tuple[int, int]) -> None:
    settings, model = vision(is_perspective=False, orthographic_size=0.5, resolution=resolution)
    assert settings.orthographic_size == pytest.approx(0.5)
    assert model.cam_fovy[0] == pytest.approx(0.5 * resolution[1] / 64)


def test_the_angle_and_the_size_that_do_not_count_are_kept_for_a_switch() -> None:
    flat, _ = vision(is_perspective=False, orthographic_size=0.5, angle=1.2)
    assert (flat.is_perspective, flat.angle) == (False, pytest.approx(1.2))
    deep, _ = vision(orthographic_size=0.5, angle=1.2)
    assert (deep.is_perspective, deep.size) == (True, pytest.approx(0.5))


@pytest.mark.parametrize("mode", [0, 1, 2, 3, 5, 6, 7, 8])
def test_a_render_mode_goes_over(mode: int) -> None:
    assert vision(render_mode=mode)[0].render_mode == mode


def test_switches_of_a_vision_sensor_go_over() -> None:
    settings, _ = vision(
        is_explicit=True,
        is_external=True,
        ignores_rgb=True,
        ignores_depth=True,
        has_no_statistics=True,
        render_mode=2,
        default_color=(0.2, 0.4, 2.0),
    )
    assert settings.explicit
    assert settings.external
    assert settings.shows_handles
    assert (settings.has_rgb, settings.has_depth, settings.has_statistics) == (False, False, False)
    assert settings.background == pytest.approx((0.2, 0.4, 1.0))
    assert vision(uses_environment_background=True, default_color=(1.0, 0.0, 0.0))[0].background is None


def test_background_of_the_environment_is_the_fog() -> None:
    sensor = VisionSensor(handle=9, name="eye", uses_environment_background=True)
    conversion = conversion_of(sensor, settings=Settings(fog=(0.5, 0.25, 1.0)))
    scene, model = scene_of(conversion, add_vision, TURNED, sensor)
    item = scene.objects[scene.of_kind(ObjectKind.VISION_SENSOR)[0]]
    assert settings_from_model(item, model).background == (0.5, 0.25, 1.0)


def test_hopeless_view_becomes_one_that_can_be_rendered() -> None:
    settings, _ = vision(resolution=(0, 10**9), near=-1.0, far=math.nan, angle=math.inf)
    assert (settings.width, settings.height) == (1, 4096)
    assert 0 < settings.near < settings.far < math.inf
    assert 0 < settings.angle < math.pi


def test_camera_of_the_user_interface_is_no_vision_sensor() -> None:
    camera = Camera(handle=1, name="view", angle=1.0, near=0.05, far=70.0, tracked=1)
    conversion = conversion_of(camera)
    scene, model = scene_of(conversion, add_camera, TURNED, camera)
    item = scene.objects[scene.of_kind(ObjectKind.CAMERA)[0]]
    settings = settings_from_model(item, model)
    assert settings.angle == pytest.approx(1.0)
    assert (settings.near, settings.far) == (0.05, 70.0)
    assert list(conversion.report.left_out.values()) == [["view"]]
    flat = Camera(handle=1, name="view", is_perspective=False, orthographic_size=4.0)
    scene, model = scene_of(conversion_of(flat), add_camera, TURNED, flat)
    item = scene.objects[scene.of_kind(ObjectKind.CAMERA)[0]]
    assert settings_from_model(item, model).orthographic_size == pytest.approx(4.0)


def test_lights_have_the_colours_of_the_file_and_shine_along_z() -> None:
    color = Material(light=(0.4, 0.3, 0.2), specular=(0.9, 0.8, 7.0))
    spot = Light(
        handle=1,
        name="lamp",
        type=2,
        exponent=30,
        cutoff=math.radians(40),
        attenuation=(0.5, 0.0, 0.25),
        color=color,
    )
    scene, model = scene_of(conversion_of(spot), add_light, TURNED, spot)
    light = model.light("lamp")
    assert scene.of_kind(ObjectKind.LIGHT) == [scene.by_name("lamp")]
    assert light.type == mujoco.mjtLightType.mjLIGHT_SPOT
    assert_allclose(light.dir, [1, 0, 0], atol=1e-7)
    assert_allclose(light.diffuse, [0.4, 0.3, 0.2])
    assert_allclose(light.specular, [0.9, 0.8, 1.0])
    assert_allclose(light.ambient, 0)
    assert_allclose(light.attenuation, [0.5, 0, 0.25])
    assert (light.cutoff, light.exponent) == (pytest.approx(40), 30)
    assert light.active
    assert not light.castshadow


@pytest.mark.parametrize(("number", "kind"), [(1, "SPOT"), (3, "DIRECTIONAL"), (9, "SPOT")])
def test_other_types_of_lights_shine_in_all_directions_or_in_one(number: int, kind: str) -> None:
    lamp = Light(handle=1, name="lamp", type=number, is_on=False, cutoff=0.1, attenuation=(0.0, 0.0, 0.0))
    conversion = conversion_of(lamp)
    _, model = scene_of(conversion, add_light, TURNED, lamp)
    assert model.light("lamp").type == getattr(mujoco.mjtLightType, f"mjLIGHT_{kind}")
    cone = 180.0 if kind == "SPOT" else pytest.approx(math.degrees(0.1), rel=1e-6)  # without effect
    assert (model.light("lamp").cutoff, model.light("lamp").exponent) == (cone, 20.0)
    assert not model.light("lamp").active
    assert model.light("lamp").attenuation.any()
    assert bool(conversion.report.approximated) == (number == 9)


def test_ambient_light_of_the_scene_is_the_only_light_of_the_viewer() -> None:
    conversion = conversion_of(settings=Settings(ambient=(0.4, 0.5, 0.6)))
    set_surroundings(conversion)
    headlight = conversion.spec.compile().vis.headlight
    assert_allclose(headlight.ambient, [0.4, 0.5, 0.6])
    assert_allclose(headlight.diffuse, 0)
    assert_allclose(headlight.specular, 0)


def test_lights_beyond_the_seventh_are_reported() -> None:
    lamps = [Light(handle=i, name=f"lamp{i}", is_on=i != 3) for i in range(9)]
    conversion = conversion_of(*lamps)
    set_surroundings(conversion)
    assert list(conversion.report.left_out.values()) == [["lamp8"]]


def test_mills_and_mirrors_are_named_and_scripts_are_not() -> None:
    kinds = ("mill", "mirror", "script")
    conversion = conversion_of(*(OtherObject(handle=i, name=kind, kind=kind) for i, kind in enumerate(kinds)))
    report_inert(conversion)
    assert list(conversion.report.left_out.values()) == [["mill"], ["mirror"]]


ODD = (math.nan, math.inf, -math.inf, -1.0, 0.0, 1e-300, 1e300, 0.5, 3e38)
WHOLE = (-(2**31), -1, 0, 1, 7, 2**31 - 1)
ADDERS = {
    ProximitySensor: add_proximity,
    VisionSensor: add_vision,
    ForceSensor: add_force_sensor,
    Camera: add_camera,
    Light: add_light,
}


def odd(random: np.random.Generator, known: object) -> object:
    """A value of the same type as a known one, which a file may hold."""
    if isinstance(known, bool):
        return bool(random.integers(2))
    if isinstance(known, int):
        return int(random.choice(WHOLE))
    if isinstance(known, float):
        return float(random.choice(ODD))
    if isinstance(known, tuple):
        return tuple(odd(random, each) for each in known)
    return known


@pytest.mark.parametrize("kind", ADDERS)
def test_no_numbers_of_a_file_make_a_scene_that_cannot_be_loaded(kind: type) -> None:
    random = np.random.default_rng(11)
    for _ in range(60):
        item = kind(handle=5, name="odd")
        parts = [item, *(part for part in vars(item).values() if isinstance(part, (Volume, Material)))]
        for part in parts:
            for key, value in vars(part).items():
                if key not in ("handle", "name", "parent", "pose"):
                    setattr(part, key, odd(random, value))
        if isinstance(item, ProximitySensor):
            item.volume.type = str(random.choice(["ray", "cone", "disc", "cylinder", "pyramid", "unknown"]))
            item.method = str(random.choice(["ray", item.volume.type]))
            item.minimum_distance = item.max_normal_angle = float(random.choice(ODD))
        if isinstance(item, ForceSensor):
            item.max_force, item.max_torque = float(random.choice(ODD)), float(random.choice(ODD))
        scene, model = scene_of(conversion_of(item), ADDERS[kind], TURNED, item)
        found = next(one for one in scene.objects.values() if one.name == "odd")
        if found.kind in (ObjectKind.VISION_SENSOR, ObjectKind.CAMERA):
            settings = settings_from_model(found, model)
            CameraView(0, settings.width, settings.height, 45.0, settings.near, settings.far)
            assert 0 < settings.angle < math.pi
            assert settings.orthographic_size is None or 0 < settings.orthographic_size < math.inf
        if found.kind is ObjectKind.PROXIMITY_SENSOR:
            assert math.isfinite(optics(found.annotations["proximity"], 1.0).volume.reach)
