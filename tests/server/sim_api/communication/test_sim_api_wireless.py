"""Wireless messages between scripts: who receives what, where and how long."""

from __future__ import annotations

import pytest
from handler_calls import World
from scripted_world import evaluate, scripted

from simx_server.errors import CommandError

BODY = """
<body name="hub"><geom size="0.1" contype="0" conaffinity="0"/>
  <body name="leaf" pos="0 0 1"><geom size="0.1" contype="0" conaffinity="0"/></body></body>
<body name="east" pos="2 0 0"><geom size="0.1" contype="0" conaffinity="0"/></body>
<body name="west" pos="-2 0 0"><geom size="0.1" contype="0" conaffinity="0"/></body>
"""

ALL = "sim.handle_all"
EVERYWHERE = "sim.handle_self, 10"
"""Antenna, and a radius in metres."""


@pytest.fixture
def world() -> World:
    found = scripted(dict.fromkeys((f"lua:{on}" for on in ("hub", "leaf", "east", "west")), "x = 1"), BODY)
    found.run(0)
    return found


def send(world: World, data: str, *, target: object = ALL, to: str = EVERYWHERE) -> None:
    evaluate(world, f"sim.sendData({target}, 7, 'news', '{data}', {to})", on="hub")


def heard(world: World, on: str, arguments: str = "") -> bytes | None:
    return evaluate(world, f"return (sim.receiveData({arguments}))", on=on)[0]


def receivers_of(world: World) -> set[str]:
    return {on for on in ("hub", "leaf", "east", "west") if heard(world, on)}


def handle_of(world: World, on: str) -> int:
    return evaluate(world, "return sim.getScriptHandle()", on=on)[0]


def test_every_other_script_receives_a_message_once(world: World) -> None:
    send(world, "hello")
    assert [heard(world, on) for on in ("hub", "leaf", "east", "west")] == [
        None,
        b"hello",
        b"hello",
        b"hello",
    ]
    assert heard(world, "east") is None


def test_a_message_names_its_sender_header_and_name(world: World) -> None:
    send(world, "x")
    assert evaluate(world, "return sim.receiveData(7, 'news')", on="east") == [
        b"x",
        handle_of(world, "hub"),
        7,
        b"news",
    ]


def test_messages_of_another_header_or_name_are_left(world: World) -> None:
    send(world, "x")
    assert heard(world, "east", "8") is None
    assert heard(world, "east", "7, 'other'") is None
    assert heard(world, "east", "7") == b"x"


def test_an_index_reads_without_receiving(world: World) -> None:
    send(world, "one")
    send(world, "two")
    read = "-1, nil, sim.handle_self, %d"
    assert [heard(world, "east", read % index) for index in (1, 1, 0, 2)] == [b"two", b"two", b"one", None]


@pytest.mark.parametrize(
    ("target", "receivers"),
    [
        ("sim.handle_tree", {"leaf"}),
        ("sim.handle_chain", set[str]()),
        (ALL, {"leaf", "east", "west"}),
    ],
)
def test_the_target_selects_scripts_of_the_tree(world: World, target: str, receivers: set[str]) -> None:
    send(world, "x", target=target)
    assert receivers_of(world) == receivers


def test_a_message_to_one_script_is_for_that_one(world: World) -> None:
    send(world, "x", target=handle_of(world, "east"))
    assert receivers_of(world) == {"east"}


@pytest.mark.parametrize(
    ("area", "receivers"),
    [
        ("sim.handle_self, 1.5", {"leaf"}),
        ("sim.handle_self, 10, 3.1415, 1", {"leaf", "east"}),
        ("sim.handle_self, 10, 1, 6.283", {"east", "west"}),
        ("sim.handle_self, 10, 3.1415, 6.283", {"leaf", "east", "west"}),
        ("sim.getObject('/east'), 0.5", {"east"}),
        ("sim.handle_default, 1.5", {"leaf"}),
    ],
    ids=["near", "ahead", "flat", "all around", "another antenna", "origin"],
)
def test_the_area_decides_who_receives(world: World, area: str, receivers: set[str]) -> None:
    send(world, "x", to=area)
    assert receivers_of(world) == receivers


def test_a_message_lasts_one_and_a_half_steps_or_as_long_as_it_says(world: World) -> None:
    send(world, "short")
    send(world, "long", to=f"{EVERYWHERE}, 3.1416, 6.2832, 0.2")
    world.parts.step()
    assert heard(world, "east") == b"short"
    world.parts.step()
    assert heard(world, "west") == b"long"
    for _ in range(3):
        world.parts.step()
    assert heard(world, "leaf") is None


def test_a_stop_ends_all_messages(world: World) -> None:
    send(world, "x", to=f"{EVERYWHERE}, 3.1416, 6.2832, 100")
    world.sim.stop()
    world.run(0)
    assert receivers_of(world) == set()


def test_an_unknown_target_is_refused_with_the_scripts(world: World) -> None:
    with pytest.raises(CommandError, match=r"77 is no receiver; .* child script of 'east'"):
        send(world, "x", target=77)
