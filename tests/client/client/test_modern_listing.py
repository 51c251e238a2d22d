"""``Client.objects``: all objects of a scene, each as what it is."""

from __future__ import annotations

import pytest
from modern_world import messages_of
from real_world import RealWorld, path_of

import simx_client as v
from simx_client import Client, errors
from simx_client.client import Camera, Dummy, ForceSensor, Joint, Object, ProximitySensor, SceneObject, Shape


def test_all_objects_are_listed_as_what_they_are_with_one_message(client: Client) -> None:
    sizes = messages_of(client)
    listed = client.objects()
    kinds = {
        "shoulder": Joint, "above": Camera, "eye": ProximitySensor, "cell": ForceSensor, "tip": Dummy, "red": Shape,
    }  # fmt: skip
    assert {name: type(listed[name]) for name in kinds} == kinds
    assert {each.name: each.kind for each in listed}["light1"] == "light"
    assert sizes == [2], "names and types"
    shoulder = listed["shoulder"]
    assert isinstance(shoulder, Joint)
    assert shoulder.position is not None, "each can be used at once"
    handles = v.simxGetObjects(client.id, v.sim_handle_all, v.simx_opmode_blocking)[1]
    assert [each.handle for each in listed] == handles, "in the scene's order"
    assert listed.names == [each.name for each in listed]


def test_objects_of_one_class_are_listed_alone(client: Client) -> None:
    assert client.objects(Joint).names == ["shoulder", "wrist", "axle"]
    assert {each.kind for each in client.objects(Object)} >= {"camera", "shape", "dummy"}
    assert not any(isinstance(each, Joint) for each in client.objects(Object))
    with pytest.raises(TypeError, match=r"client\.Joint, not 'joint'"):
        client.objects("joint")  # type: ignore[call-overload]


def test_a_listed_object_is_the_one_that_its_name_finds(client: Client) -> None:
    listed = client.objects()
    assert client.joint("shoulder") is listed["shoulder"]
    assert "shoulder" in listed
    assert client.joint("shoulder") in listed
    assert "sholder" not in listed
    assert listed[1:3].names == listed.names[1:3]
    with pytest.raises(errors.NoSuchObject, match=r"^no object named 'sholder'; did you mean 'shoulder'\?"):
        listed["sholder"]


def test_objects_of_a_scene_that_was_replaced_are_listed_anew(world: RealWorld, client: Client) -> None:
    before = client.objects()
    world.simulation.load(path_of(world))
    after = client.objects()
    assert after.names == before.names
    assert client.joint("shoulder") is after["shoulder"]
    assert after["shoulder"] is not before["shoulder"]
    with pytest.raises(errors.ObjectGone):
        before["shoulder"].pose  # noqa: B018


def test_an_object_knows_its_kind_however_it_was_found(client: Client) -> None:
    assert (client.object("shoulder").kind, type(client.object("shoulder"))) == ("joint", Object)
    assert client.shape("red").kind == client.object("red").kind == "shape"
    parent = client.joint("wrist").parent
    assert parent is not None
    assert isinstance(parent, SceneObject)
    assert parent.kind == "object", "its handle alone is known"
    with pytest.raises(errors.WrongKind, match="'red' is a shape, not a dummy"):
        client.dummy("red")
