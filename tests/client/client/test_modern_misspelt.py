"""A misspelt attribute of the modern face, read or set, raises AttributeError with the nearest name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from simx_client import Client, batch
from simx_client.calls.answers import Answer
from simx_client.client import Joints, Place, SceneObject, Signals, Simulation, State, Stepping, Watch

THINGS: dict[str, tuple[Callable[[Client], Any], str, str]] = {
    "client": (lambda client: client, "simulaton", "simulation"),
    "joint": (lambda client: client.joint("shoulder"), "target_positon", "target_position"),
    "camera": (lambda client: client.camera("above"), "perspectiv_angle", "perspective_angle"),
    "shape": (lambda client: client.shape("red"), "positon", "position"),
    "dummy": (lambda client: client.dummy("tip"), "quaternoin", "quaternion"),
    "proximity sensor": (lambda client: client.proximity_sensor("eye"), "raed", "read"),
    "force sensor": (lambda client: client.force_sensor("cell"), "is_brocken", "is_broken"),
    "joints": (lambda client: client.joints("shoulder"), "positons", "positions"),
    "objects": (lambda client: client.objects(), "name", "names"),
    "place": (lambda client: client.object("red").relative_to(None), "euler_angels", "euler_angles"),
    "pose": (lambda client: client.object("red").pose, "positon", "position"),
    "signals": (lambda client: client.signals, "float", "floats"),
    "signals of a kind": (lambda client: client.signals.ints, "gett", "get"),
    "simulation": (lambda client: client.simulation, "strat", "start"),
    "stepping": (lambda client: client.stepping(), "lastest", "latest"),
    "batch calls": (lambda client: batch.Calls(0, "here"), "simxGetJointPositon", "simxGetJointPosition"),
    "answer": (lambda client: batch.Calls(0, "here").simxGetObjects(1), "valeu", "value"),
    "servers": (lambda client: batch.Servers([client.id]), "observation", "observations"),
}


@pytest.mark.parametrize("thing", THINGS)
def test_reading_or_setting_a_misspelt_attribute_names_the_nearest(client: Client, thing: str) -> None:
    make, wrong, right = THINGS[thing]
    it = make(client)
    with pytest.raises(AttributeError, match=rf"no attribute '{wrong}'; did you mean '{right}'\?$") as told:
        getattr(it, wrong)
    assert told.value.name == wrong
    with pytest.raises(AttributeError):
        setattr(it, wrong, 1)
    assert not hasattr(it, wrong)


@pytest.mark.parametrize(
    "thing", ["client", "joint", "camera", "joints", "place", "signals", "simulation", "servers"]
)
def test_what_is_set_by_a_wrong_name_says_the_right_one(client: Client, thing: str) -> None:
    make, wrong, right = THINGS[thing]
    with pytest.raises(AttributeError, match=rf"no attribute '{wrong}'; did you mean '{right}'\?$"):
        setattr(make(client), wrong, 1)


def test_nothing_like_it_lists_what_there_is(client: Client) -> None:
    with pytest.raises(
        AttributeError, match=r"no attribute 'zzz'; it has: pause, start, state, stop, time, time_step$"
    ):
        client.simulation.zzz  # type: ignore[attr-defined]  # noqa: B018


def test_an_attribute_of_another_kind_says_where_it_is(client: Client) -> None:
    with pytest.raises(AttributeError, match=r"'target_position'; client\.joint\('shoulder'\) has it$"):
        client.object("shoulder").target_position = 1.0  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"'rgb'; a camera has it; shape 'red' is not one$"):
        client.object("red").rgb()  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"'angular_velocity'; client\.object\('shoulder'\) has it$"):
        client.joint("shoulder").angular_velocity  # type: ignore[attr-defined]  # noqa: B018


def test_what_cannot_be_set_or_read_keeps_its_own_words(client: Client) -> None:
    shoulder = client.joint("shoulder")
    with pytest.raises(AttributeError, match="write only"):
        shoulder.target_position  # noqa: B018
    with pytest.raises(AttributeError, match="'velocity' of 'Joint' object has no setter"):
        shoulder.velocity = 1  # type: ignore[misc]


def test_a_class_that_a_user_derives_may_have_attributes_of_its_own(client: Client) -> None:
    class Robot(Client):
        def __init__(self) -> None:
            self.gripper = "RG2"

    assert Robot().gripper == "RG2"


def test_no_class_of_the_modern_face_takes_any_attribute() -> None:
    classes = [Client, SceneObject, Joints, Place, Signals, Simulation, Stepping, Watch, Answer, batch.Batch,
               batch.Calls, batch.Servers]  # fmt: skip
    assert [each for each in classes if each.__dictoffset__] == []
    assert [each for each in SceneObject.__subclasses__() if each.__dictoffset__] == []
    with pytest.raises(AttributeError):
        State.RUNING  # type: ignore[attr-defined]  # noqa: B018
