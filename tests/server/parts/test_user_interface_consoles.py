"""Auxiliary consoles: what is kept of what was printed, and when they are hidden or closed."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import pytest
from handler_calls import World

from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.parts.user_interface.consoles import MAX_CHARACTERS

pytestmark = pytest.mark.slow

PLAIN = (None, None, None, None)


@pytest.fixture
def world(tmp_path: Path) -> World:
    return World(workspace=tmp_path)


def open_console(world: World, title: str = "title", lines: int = 10, mode: int = 0) -> int:
    return world.call("simxAuxiliaryConsoleOpen", title, lines, mode, *PLAIN)


def describe(world: World, handle: int) -> dict[str, Any]:
    return next(each for each in world.parts.user_interface.consoles.describe() if each["handle"] == handle)


def text_of(world: World, handle: int) -> list[str]:
    return describe(world, handle)["lines"]


def test_text_is_appended_and_lines_end_where_they_say(world: World) -> None:
    console = open_console(world)
    for text in ("one", " more\ntwo\n", "\n", "three"):
        world.call("simxAuxiliaryConsolePrint", console, text)
    assert text_of(world, console) == ["one more", "two", "", "three"]
    world.call("simxAuxiliaryConsolePrint", console, None)
    assert text_of(world, console) == []
    world.call("simxAuxiliaryConsolePrint", console, "anew")
    assert text_of(world, console) == ["anew"]


def test_only_the_newest_lines_are_kept(world: World) -> None:
    console = open_console(world, lines=3)
    world.call("simxAuxiliaryConsolePrint", console, "1\n2\n3\n4\n")
    world.call("simxAuxiliaryConsolePrint", console, "5")
    assert text_of(world, console) == ["3", "4", "5"]
    world.call("simxAuxiliaryConsolePrint", console, "x" * (2 * MAX_CHARACTERS))
    assert text_of(world, console) == ["x" * MAX_CHARACTERS]
    with pytest.raises(CommandError, match="at least 1 line, not 0"):
        open_console(world, lines=0)


def test_what_is_printed_is_in_the_log_without_steering_a_terminal(
    world: World, caplog: pytest.LogCaptureFixture
) -> None:
    console = open_console(world, "weather")
    with caplog.at_level(logging.INFO, "simx_server.parts.user_interface"):
        world.call("simxAuxiliaryConsolePrint", console, "rain\x1b[2J\n")
    assert caplog.messages == ["console 'weather': rain [2J "]


def test_place_and_colours_are_kept(world: World) -> None:
    console = world.call(
        "simxAuxiliaryConsoleOpen", "t", 5, 2, [10, -20], [300, 200], [1.0, 0.5, 7.0], [0.0, -1.0, 0.0]
    )
    shown = describe(world, console)
    assert (shown["position"], shown["size"]) == ([10, -20], [300, 200])
    assert (shown["text_color"], shown["background_color"]) == ([1.0, 0.5, 1.0], [0.0, 0.0, 0.0])
    assert shown["wrap_lines"]
    assert not shown["user_may_close"]


def test_mode_bit_0_closes_at_the_end_of_the_simulation(world: World) -> None:
    staying, going = open_console(world), open_console(world, mode=1)
    world.run()
    assert describe(world, going)["visible"]
    world.call("simxStopSimulation")
    assert [console.handle for console in world.parts.user_interface.consoles] == [staying]


def test_mode_bit_2_lets_people_close_it_and_printing_goes_on_without_error(world: World) -> None:
    firm, closable = open_console(world), open_console(world, mode=4)
    with pytest.raises(CommandError, match="mode bit 2"):
        world.parts.user_interface.consoles.close_by_user(firm)
    world.parts.user_interface.consoles.close_by_user(closable)
    world.call("simxAuxiliaryConsolePrint", closable, "nobody reads this")
    world.call("simxAuxiliaryConsoleShow", closable, True)
    assert [console.handle for console in world.parts.user_interface.consoles] == [firm]


def test_mode_bit_3_hides_during_a_pause(world: World) -> None:
    staying, hiding = open_console(world), open_console(world, mode=8)
    world.run()
    world.call("simxPauseSimulation")
    assert (describe(world, staying)["visible"], describe(world, hiding)["visible"]) == (True, False)
    world.call("simxStartSimulation")
    assert describe(world, hiding)["visible"]


def test_another_scene_hides_a_console_unless_mode_bit_4_is_set(world: World) -> None:
    hiding, staying = open_console(world), open_console(world, mode=16)
    world.call("simxCloseScene")
    assert (describe(world, hiding)["visible"], describe(world, staying)["visible"]) == (False, True)
    world.call("simxAuxiliaryConsoleShow", hiding, True)
    assert describe(world, hiding)["visible"]
    world.call("simxAuxiliaryConsoleShow", hiding, False)
    assert not describe(world, hiding)["visible"]


def test_closing_is_never_an_error_and_a_handle_that_never_was_cannot_be_printed_to(world: World) -> None:
    console = open_console(world, "mine")
    world.call("simxAuxiliaryConsoleClose", 99)
    for command, value in (("simxAuxiliaryConsolePrint", "x"), ("simxAuxiliaryConsoleShow", True)):
        with pytest.raises(CommandError, match=rf"handle 99; open are: {console} \('mine'\)"):
            world.call(command, 99, value)
    world.call("simxAuxiliaryConsoleClose", console)
    world.call("simxAuxiliaryConsolePrint", console, "late")
    assert open_console(world) == console + 1, "a handle is never given twice"


def test_too_many_consoles_are_refused(world: World) -> None:
    for _ in range(Limits().consoles):
        open_console(world)
    with pytest.raises(CommandError, match=f"at most {Limits().consoles} consoles"):
        open_console(world)
