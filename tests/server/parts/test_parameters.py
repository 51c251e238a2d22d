"""The simulator's numbered parameters and what a session is told: values, limits, what can be set when."""

from __future__ import annotations

import ctypes
import logging
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from handler_calls import World
from real_world import BLOCKING, RealWorld
from sim_api_calls import ScriptWorld

import simx_client as v
from simx_server.errors import CommandError
from simx_server.service.clock import Pacer
from simx_server.settings.gathering import gather

FALLING = '<mujoco><worldbody><body name="ball" pos="0 0 5"><freejoint/><geom size=".1"/></body></worldbody></mujoco>'


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "scene.xml").write_text(FALLING, encoding="utf-8")
    return World(file=tmp_path / "scene.xml", workspace=tmp_path)


@pytest.fixture
def real(tmp_path: Path) -> Iterator[RealWorld]:
    (tmp_path / "scene.xml").write_text(FALLING, encoding="utf-8")
    world = RealWorld(tmp_path / "scene.xml", workspace=tmp_path)
    yield world
    world.close()


def test_switches_and_colours_belong_to_the_scene_and_outlive_a_run(world: World, tmp_path: Path) -> None:
    switches = (2, 3, 6, 9, 10)

    def state() -> list[object]:
        on = [world.call("simxGetBooleanParameter", number) for number in switches]
        return [*on, world.call("simxGetIntegerParameter", 11), world.call("simxGetArrayParameter", 2)]

    at_first = state()
    assert at_first == [True] * 5 + [0x00FF, [0.0, 0.0, 0.0]]
    for number in switches:
        world.call("simxSetBooleanParameter", number, False)
    world.call("simxSetIntegerParameter", 11, 1)
    world.call("simxSetArrayParameter", 2, [0.5, 0.5, 0.5])
    changed = state()
    assert changed[:5] == [False] * 5
    world.run(1)
    world.call("simxStopSimulation")
    assert state() == changed, "it is no run's"
    world.call("simxLoadScene", "scene.xml", 0)
    assert state() == at_first
    world.call("simxSetBooleanParameter", 6, False)
    world.call("simxCloseScene")
    assert state() == at_first


# --- booleans -------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [0, 1, 12, 13, 16, 17, 18, 27, 28, 33, 35, 36, 37, 38, 42, 43, 44])
def test_what_needs_a_window_is_off_and_says_so(world: World, number: int) -> None:
    world.call("simxSetBooleanParameter", number, False)
    assert world.call("simxGetBooleanParameter", number) is False
    with pytest.raises(CommandError, match="stays False: it needs a window"):
        world.call("simxSetBooleanParameter", number, True)


@pytest.mark.parametrize(
    ("number", "value", "reason"),
    [
        (4, False, "no such module"),
        (11, False, "no such module"),
        (19, False, "drawn without it"),
        (22, False, "drawn without it"),
        (29, False, "records no videos"),
        (7, True, "joints always move"),
        (24, True, "always copied whole"),
        (15, True, "always drawn with it"),
        (32, True, "beside the physics"),
    ],
)
def test_what_cannot_be_switched_here_says_why(world: World, number: int, value: bool, reason: str) -> None:
    assert world.call("simxGetBooleanParameter", number) is value
    world.call("simxSetBooleanParameter", number, value)
    with pytest.raises(CommandError, match=f"stays {value}: .*{reason}"):
        world.call("simxSetBooleanParameter", number, not value)


@pytest.mark.parametrize(("number", "value"), [(20, True), (21, True), (34, True), (45, False)])
def test_read_only_booleans_cannot_be_set(world: World, number: int, value: bool) -> None:
    assert world.call("simxGetBooleanParameter", number) is value
    with pytest.raises(CommandError, match=f"boolean parameter {number} cannot be set"):
        world.call("simxSetBooleanParameter", number, value)


def test_without_dynamics_time_passes_and_nothing_falls(world: World) -> None:
    ball = world.handle("ball")
    world.call("simxSetBooleanParameter", 6, False)
    world.run(3)
    assert world.call("simxGetObjectPosition", ball, -1) == [0, 0, 5]
    assert world.sim.time == pytest.approx(0.15)
    world.call("simxSetBooleanParameter", 6, True)
    world.parts.step()
    assert world.call("simxGetObjectPosition", ball, -1)[2] < 5


def test_exit_is_requested_only_while_stopped_and_cannot_be_read(world: World) -> None:
    asked: list[bool] = []
    with pytest.raises(CommandError, match="no server"):
        world.call("simxSetBooleanParameter", 41, True)
    world.parts.parameters.served_by(Pacer(1.0), lambda: False, lambda: asked.append(True))
    world.call("simxSetBooleanParameter", 41, False)
    world.run()
    with pytest.raises(CommandError, match="stop it first"):
        world.call("simxSetBooleanParameter", 41, True)
    assert not asked
    world.call("simxStopSimulation")
    world.call("simxSetBooleanParameter", 41, True)
    assert asked
    with pytest.raises(CommandError, match="cannot be read"):
        world.call("simxGetBooleanParameter", 41)


# --- integers -------------------------------------------------------------------------------------


def test_integers_that_tell_of_the_simulator(world: World) -> None:
    expected = {1: 30602, 2: 1, 7: 25, 8: 4, 14: 0, 30: 0, 34: 0, 36: 0, 39: 3060200}
    assert {number: world.call("simxGetIntegerParameter", number) for number in expected} == expected
    for number in (1, 2, 7, 14, 19, 20, 22, 24, 29, 30, 34, 39):
        with pytest.raises(CommandError, match="cannot be set"):
            world.call("simxSetIntegerParameter", number, 0)
    with pytest.raises(CommandError, match="stays 4: the dynamics engine here is MuJoCo"):
        world.call("simxSetIntegerParameter", 8, 0)


def test_settings_of_v_reps_window_are_kept(world: World, tmp_path: Path) -> None:
    for number, value in (
        (5, 3),
        (12, 1),
        (13, 7),
        (21, 4),
        (25, 9),
        (26, 30),
        (27, -1),
        (28, 2),
        (32, 1),
        (33, 1),
    ):
        world.call("simxGetIntegerParameter", number)
        world.call("simxSetIntegerParameter", number, value)
        assert world.call("simxGetIntegerParameter", number) == value
    scripts = ScriptWorld(tmp_path)
    assert scripts.lua("return sim.setInt32Parameter(sim.intparam_current_page, 2)") == [1]
    assert scripts.lua("return sim.getInt32Parameter(sim.intparam_current_page), sim.getPage()") == [2, 2]
    for page in (-1, 8):
        with pytest.raises(CommandError, match=f"{page} is not a page; those are 0 to 7"):
            world.call("simxSetIntegerParameter", 5, page)


def test_arguments_of_the_application_can_be_set_by_scripts(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path)
    world.parts.parameters.arguments = ("first",)
    assert world.lua("return sim.setStringParameter(sim.stringparam_app_arg3, 'third')") == [1]
    arguments = [world.call("simxGetStringParameter", v.sim_stringparam_app_arg1 + n) for n in range(4)]
    assert arguments == ["first", "", "third", ""]


def test_mouse_is_where_a_page_last_saw_it(world: World) -> None:
    numbers = (v.sim_intparam_mouse_x, v.sim_intparam_mouse_y, v.sim_intparam_mouse_buttons)
    assert [world.call("simxGetIntegerParameter", number) for number in numbers] == [0, 0, 0]
    world.parts.user_interface.mouse = (120, 40, 1)  # pyright: ignore[reportAttributeAccessIssue]
    assert [world.call("simxGetIntegerParameter", number) for number in numbers] == [120, 40, 1]


def test_speed_modifier_doubles_the_pace_of_this_run(world: World) -> None:
    pace = Pacer(1.0)
    world.parts.parameters.pace = pace
    world.call("simxSetIntegerParameter", 36, 2)
    assert pace.speed == 1, "nothing happens while stopped"
    world.run()
    for index, speed in ((2, 4.0), (-1, 0.5), (1000, 1024.0)):
        world.call("simxSetIntegerParameter", 36, index)
        assert pace.speed == speed
    assert world.call("simxGetIntegerParameter", 36) == 10
    world.call("simxStopSimulation")
    assert (pace.speed, world.call("simxGetIntegerParameter", 36)) == (1.0, 0)


def test_speed_modifier_changes_nothing_without_a_pace(world: World) -> None:
    world.parts.parameters.pace = Pacer(math.inf)
    world.run()
    world.call("simxSetIntegerParameter", 36, 3)
    assert world.call("simxGetIntegerParameter", 36) == 0


def test_error_report_mode_says_where_errors_go(real: RealWorld) -> None:
    client = real.client()
    modes = {
        v.sim_api_errormessage_ignore: (0, 0),
        v.sim_api_errormessage_report: (1, 0),
        v.sim_api_errormessage_output: (0, 1),
        v.sim_api_errormessage_report | v.sim_api_errormessage_output: (1, 1),
    }
    for mode, (told, shown) in modes.items():
        assert v.simxSetIntegerParameter(client, v.sim_intparam_error_report_mode, mode, BLOCKING) == 0
        before = real.parts.status_bar.count
        assert v.simxGetJointPosition(client, 4711, BLOCKING)[0] == 8
        assert len(v.simxGetLastErrors(client, BLOCKING)[1]) == told
        assert real.parts.status_bar.count - before == shown
    assert v.simxSetIntegerParameter(client, v.sim_intparam_error_report_mode, 4, BLOCKING) == 8


# --- strings, floats, arrays ----------------------------------------------------------------------


def test_command_line_arguments_are_string_parameters(world: World) -> None:
    world.parts.parameters.arguments = ("first", "zwei")
    found = [world.call("simxGetStringParameter", number) for number in range(2, 11)]
    assert found == ["first", "zwei", *[""] * 7]
    with pytest.raises(CommandError, match="string parameter 11 cannot be read"):
        world.call("simxGetStringParameter", 11)


def test_arguments_come_from_the_flag_as_vrep_wrote_it() -> None:
    from simx_server.app.cli import make_parser

    given = vars(make_parser().parse_args(["-gfirst", "-g", "two words"]))
    assert gather(given, {}).arguments == ("first", "two words")
    assert gather({}, {"SIMX_ARGUMENT": "a b"}).arguments == ("a", "b")


def test_strings_tell_scene_and_folders(world: World, tmp_path: Path) -> None:
    expected = {13: str(tmp_path / "scene.xml"), 14: str(tmp_path), 15: "scene", 16: str(tmp_path)}
    assert {number: world.call("simxGetStringParameter", number) for number in expected} == expected
    assert Path(world.call("simxGetStringParameter", 0)).is_dir()
    world.call("simxCloseScene")
    assert [world.call("simxGetStringParameter", number) for number in (13, 14)] == ["", ""]


@pytest.mark.parametrize(
    ("kind", "number", "value"),
    [
        ("Integer", 35, 7),
        ("Floating", 2, 0.5),
        *(("Array", number, [0.25, 0.5, 0.75]) for number in (1, 3, 4, 5)),
    ],
)
def test_settings_of_vreps_own_drawing_and_machinery_are_kept(
    world: World, kind: str, number: int, value: Any
) -> None:
    world.call(f"simxSet{kind}Parameter", number, value)
    assert world.call(f"simxGet{kind}Parameter", number) == value


def test_what_vrep_tells_of_itself_has_the_values_of_one_in_which_nothing_happens(world: World) -> None:
    assert [world.call("simxGetIntegerParameter", number) for number in (3, 4, 6, 17)] == [0, 1, -1, 0]


def test_random_numbers_are_the_same_in_every_server(world: World) -> None:
    other = World()
    for command, number in (("simxGetFloatingParameter", 0), ("simxGetArrayParameter", 6)):
        drawn = [world.call(command, number) for _ in range(4)]
        assert drawn == [other.call(command, number) for _ in range(4)]


def test_read_only_floats_and_arrays_cannot_be_set(world: World) -> None:
    assert world.call("simxGetFloatingParameter", 3) == pytest.approx(0.002)
    for number in (0, 3):
        with pytest.raises(CommandError, match="cannot be set"):
            world.call("simxSetFloatingParameter", number, 1.0)
    with pytest.raises(CommandError, match="cannot be set"):
        world.call("simxSetArrayParameter", 6, [0.0, 0.0, 0.0])
    world.call("simxSetArrayParameter", 2, [0.5, 2.0, -1.0])
    assert world.call("simxGetArrayParameter", 2) == [0.5, 1.0, 0.0]


def test_time_steps_that_scripts_use_are_taken_exactly(world: World) -> None:
    for wanted in (0.001, 0.005, 0.01, 0.05, 0.1, 10.0):
        world.call("simxSetFloatingParameter", 1, wanted * (1 + 3e-8))
        assert world.sim.time_step == wanted


# --- sessions -------------------------------------------------------------------------------------


def test_real_time_switch_is_a_bit_of_the_message_header(real: RealWorld) -> None:
    client = real.client()
    for wanted in (True, False):
        v.simxSetBooleanParameter(client, v.sim_boolparam_realtime_simulation, wanted, BLOCKING)
        v.simxGetPingTime(client)
        state = v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state)
        assert state == (1, 4 * wanted)


def test_scene_id_of_the_header_is_parameter_20_and_changes_with_the_scene(real: RealWorld) -> None:
    client = real.client()
    found: list[int] = []
    for load in (None, "scene.xml", "scene.xml"):
        if load:
            assert v.simxLoadScene(client, load, 0, BLOCKING) == 0
        code, number = v.simxGetIntegerParameter(client, v.sim_intparam_scene_unique_id, BLOCKING)
        assert code == 0
        assert v.simxGetInMessageInfo(client, v.simx_headeroffset_scene_id) == (1, number)
        found.append(number)
    assert len(set(found)) == 3


def test_paused_and_running_are_bits_of_the_message_header(real: RealWorld) -> None:
    client = real.client()
    for act, bits in ((v.simxStartSimulation, 1), (v.simxPauseSimulation, 3), (v.simxStopSimulation, 0)):
        act(client, BLOCKING)
        assert v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state) == (1, bits)


def test_waiting_for_trigger_is_read_by_another_client(real: RealWorld) -> None:
    stepping, other = real.client(), real.client()
    v.simxSynchronous(stepping, True)
    v.simxStartSimulation(stepping, BLOCKING)
    assert v.simxGetBooleanParameter(other, v.sim_boolparam_waiting_for_trigger, BLOCKING) == (0, True)
    v.simxStopSimulation(other, BLOCKING)
    assert v.simxGetBooleanParameter(other, v.sim_boolparam_waiting_for_trigger, BLOCKING) == (0, False)


def test_streamed_errors_are_each_told_once_however_late_they_are_read(real: RealWorld) -> None:
    client = real.client()
    v.simxGetLastErrors(client, v.simx_opmode_streaming)
    v.simxStartSimulation(client, BLOCKING)
    for number in (101, 102, 103):
        v.simxGetObjectPosition(client, number, -1, BLOCKING)
        real.loop.turn()
    code, errors = v.simxGetLastErrors(client, v.simx_opmode_buffer)
    assert code == 0
    assert [number for number in (101, 102, 103) if any(str(number) in text for text in errors)] == [
        101,
        102,
        103,
    ]
    assert v.simxGetLastErrors(client, v.simx_opmode_buffer) == (0, [])
    v.simxGetObjectPosition(client, 104, -1, BLOCKING)
    real.loop.turn()
    v.simxGetObjectPosition(client, 105, -1, BLOCKING)
    errors = v.simxGetLastErrors(client, BLOCKING)[1]
    assert len(errors) == 2, "what the stream had brought, and the newest"
    v.simxGetLastErrors(client, v.simx_opmode_streaming)
    for number in range(200, 260):
        v.simxGetObjectPosition(client, number, -1, BLOCKING)
        real.loop.turn()
    assert len(v.simxGetLastErrors(client, v.simx_opmode_buffer)[1]) == 50


def test_unknown_parameters_are_told_and_end_nothing(
    real: RealWorld, caplog: pytest.LogCaptureFixture
) -> None:
    client = real.client()
    with caplog.at_level(logging.WARNING, "simx_client"):
        assert v.simxSetIntegerParameter(client, 4711, 1, BLOCKING) == 8
        assert v.simxGetBooleanParameter(client, 4711, BLOCKING) == (8, False)
    assert any(
        "boolean parameter 4711 cannot be read; those that can: 0, 1" in text for text in caplog.messages
    )
    assert v.simxGetPingTime(client)[0] == 0


def test_buffer_is_a_pointer_as_ctypes_programs_use_it() -> None:
    buffer = v.simxCreateBuffer(4)
    assert isinstance(buffer, ctypes.POINTER(ctypes.c_ubyte))
    buffer[0] = 7
    ctypes.memmove(ctypes.addressof(buffer.contents) + 1, b"\x01\x02\xff", 3)
    assert buffer[:4] == [7, 1, 2, 255]
    assert ctypes.string_at(buffer, 4) == b"\x07\x01\x02\xff"
    assert bytes(ctypes.cast(buffer, ctypes.POINTER(ctypes.c_ubyte * 4)).contents) == b"\x07\x01\x02\xff"
    assert v.simxReleaseBuffer(buffer) is None
