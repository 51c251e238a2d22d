"""Advice about names that do not exist: the nearest names of the scene, at little cost."""

from __future__ import annotations

from typing import NoReturn

import pytest
from handler_calls import World

from simx_server.errors import UnknownName
from simx_server.scene.formats.loader import load_text
from simx_server.scene.naming import paths
from simx_server.scene.naming.alike import names_like

ARM = [f"Panda_{part}{number}" for part in ("joint", "link", "gripper_joint") for number in range(1, 8)]
KNOWN = [*ARM, "Panda", "Panda_tip", "table", "start", "state", "shoulder", "Ölkanne", "diningTable_visible"]


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ("tabel", "table"), ("strat", "start"), ("Sholder", "shoulder"), ("Panda_tipp", "Panda_tip"),
        ("panda_Tip#1", "Panda_tip"), ("Panda_jiont3", "Panda_joint3"), ("Panda_link3_visible", "Panda_link3"),
        ("TABLE", "table"), ("diningtable", "diningTable_visible"), ("ölkane", "Ölkanne"),
        ("star", "start"),
    ],
)  # fmt: skip
def test_name_with_similar_letters_in_similar_order_is_the_first(wrong: str, expected: str) -> None:
    assert names_like(wrong, KNOWN)[0] == expected


def test_names_that_start_with_the_wrong_one_are_those_that_are_meant() -> None:
    assert names_like("Panda_j", KNOWN) == ["Panda_joint1", "Panda_joint2", "Panda_joint3"]
    assert names_like("PANDA", KNOWN) == ["Panda"]


@pytest.mark.parametrize(
    "wrong", ["", "q", "qqqq", "x" * 100_000, "nothing like this", "\0", "a\0b", "\ud800"]
)
def test_what_is_like_no_name_gets_no_advice(wrong: str) -> None:
    assert names_like(wrong, KNOWN) == []


def test_any_names_can_be_compared() -> None:
    assert names_like("table", []) == []
    assert names_like("tabl", ["", "", "table"]) == ["table"]
    assert names_like("tabl", ["", ""]) == []
    assert names_like("tabl", ["ta\0ble", "table"]) == []
    assert names_like("tabl", ["\ud800", "table"]) == ["table"]
    many = [f"thing{number}" for number in range(100_000)]
    assert names_like("thnig17", many)[0] == "thing17"


def test_names_are_compared_only_when_the_message_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_text('<mujoco><worldbody><body name="table"/></worldbody></mujoco>')[0]
    with pytest.raises(UnknownName) as caught:
        scene.resolve("tabel")
    scene.objects.clear()
    scene.reindex()
    message = "no object named 'tabel'; did you mean 'table'?"
    assert str(caught.value) == message, "by the names that the scene had"

    def compare(*_arguments: object) -> NoReturn:
        raise AssertionError("names were compared again")

    monkeypatch.setattr(paths, "names_like", compare)
    assert str(caught.value) == message
    with pytest.raises(UnknownName):
        scene.resolve("tabel")


def test_clients_of_the_legacy_remote_api_get_the_advice() -> None:
    world = World('<mujoco><worldbody><body name="table"/></worldbody></mujoco>')
    with pytest.raises(UnknownName, match="no object named 'tabel'; did you mean 'table'"):
        world.call("simxGetObjectHandle", "tabel")
