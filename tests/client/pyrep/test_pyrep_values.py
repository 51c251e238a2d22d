"""Functions of parameters, signals, scripts and stacks, and of files, called as PyRep calls them."""

from __future__ import annotations

from pathlib import Path

import pytest
from c_program import CProgram, Out, ffi, numbers, text
from processes import ROOT

from simx_client.protocol import constants as c

CUSTOMIZATION = 6
TABLES = (
    Out("int **"), Out("int *"), Out("float **"), Out("int *"), Out("char ***"), Out("int *"), Out("char **"),
    Out("int *"),
)  # fmt: skip
BULLET_FRICTION = 6003


def test_parameters_of_the_simulator(program: CProgram) -> None:
    lib = program.lib
    gravity = c.sim_arrayparam_gravity
    program.done("simSetArrayParameter", gravity, [0.0, 0.0, -1.5])
    assert program.done("simGetArrayParameter", gravity, Out("float[3]")) == [0, 0, -1.5]
    program.done("simSetBoolParameter", c.sim_boolparam_display_enabled, False)
    assert lib.simGetBoolParameter(c.sim_boolparam_display_enabled) in (0, 1)
    assert lib.simGetInt32Parameter(c.sim_intparam_program_version) >= 40000
    program.done("simSetInt32Parameter", c.sim_intparam_error_report_mode, 0)
    assert lib.simGetStringParameter(c.sim_stringparam_app_arg1) is not None
    assert lib.simSetStringParameter(c.sim_stringparam_app_arg1, b"x") == 1
    assert text(lib.simGetStringParameter(c.sim_stringparam_app_arg1)) == "x"
    step = c.sim_floatparam_simulation_time_step
    program.done("simSetFloatParameter", step, 0.02)
    assert lib.simGetFloatParameter(step) == lib.simGetSimulationTimeStep() == pytest.approx(0.02)


def test_a_shape_has_a_friction_of_the_engine(program: CProgram) -> None:
    cube = program.handle("cube")
    program.done("simSetEngineFloatParameter", BULLET_FRICTION, cube, ffi.NULL, 0.25)
    found = program.lib.simGetEngineFloatParameter(
        BULLET_FRICTION, cube, ffi.NULL, ffi.new("unsigned char *")
    )
    assert found == 0.25


@pytest.mark.parametrize(
    ("kind", "value", "pointer"),
    [("Integer", 7, "int*"), ("Float", 0.5, "float*"), ("Double", 0.25, "double*")],
)
def test_signals_of_numbers(program: CProgram, kind: str, value: float, pointer: str) -> None:
    assert program.call(f"simGet{kind}Signal", b"s", Out(pointer))[0] == 0
    program.done(f"simSet{kind}Signal", b"s", value)
    assert program.call(f"simGet{kind}Signal", b"s", Out(pointer)) == (1, value)
    assert getattr(program.lib, f"simClear{kind}Signal")(b"s") == 1


def test_every_function_of_signals_of_numbers_has_its_name(program: CProgram) -> None:
    lib = program.lib
    for functions in (
        (lib.simSetIntegerSignal, lib.simGetIntegerSignal, lib.simClearIntegerSignal),
        (lib.simSetFloatSignal, lib.simGetFloatSignal, lib.simClearFloatSignal),
        (lib.simSetDoubleSignal, lib.simGetDoubleSignal, lib.simClearDoubleSignal),
    ):
        setter, getter, clear = functions
        assert setter(b"s", 1) == getter(b"s", ffi.NULL) == clear(b"s") == 1


def test_a_signal_of_bytes_keeps_its_zeros(program: CProgram) -> None:
    program.done("simSetStringSignal", b"s", b"a\0b", 3)
    pointer, length = program.call("simGetStringSignal", b"s", Out("int*"))
    assert b"".join(numbers(pointer, length)) == b"a\0b"
    program.done("simClearStringSignal", b"s")
    assert program.lib.simGetStringSignal(b"s", ffi.new("int*")) == ffi.NULL


def test_functions_of_scripts_take_and_give_four_tables(program: CProgram) -> None:
    program.run(1)
    strings = [ffi.new("char[]", b"one"), ffi.new("char[]", b"two")]
    result, *found = program.call(
        "simExtCallScriptFunction", c.sim_scripttype_childscript, b"echo@robot", [1, 2], 2, [0.5], 1,
        ffi.new("char *[]", strings), 2, b"bytes", 5, *TABLES,
    )  # fmt: skip
    ints, int_count, floats, float_count, texts, text_count, buffer, buffer_size = found
    assert result == 1
    assert numbers(ints, int_count) == [1, 2]
    assert numbers(floats, float_count) == [0.5]
    assert [text(each) for each in numbers(texts, text_count)] == ["one", "two"]
    assert (text(buffer), buffer_size) == ("bytes", 5)


def test_a_function_that_fails_gives_its_reason(
    program: CProgram, capsys: pytest.CaptureFixture[str]
) -> None:
    program.run(1)
    arguments = [[], 0, [], 0, ffi.new("char *[]", 1), 0, b"", 0]
    call = program.call
    assert (
        call("simExtCallScriptFunction", c.sim_scripttype_childscript, b"fails@robot", *arguments, *TABLES)[0]
        == -1
    )
    assert "on purpose" in capsys.readouterr().err


def test_scripts_are_added_and_read(program: CProgram) -> None:
    lib = program.lib
    script = lib.simAddScript(CUSTOMIZATION)
    assert script > 0
    program.done("simSetScriptText", script, b"x = 1")
    assert text(lib.simGetScriptText(script)) == "x = 1"
    program.done("simAssociateScriptWithObject", script, program.handle("cube"))
    assert lib.simGetScriptAssociatedWithObject(program.handle("robot")) > 0
    assert lib.simGetScriptAssociatedWithObject(program.handle("wall")) == -1


def test_stacks_keep_values(program: CProgram) -> None:
    lib = program.lib
    stack = lib.simCreateStack()
    program.done("simPushInt32OntoStack", stack, 5)
    assert program.call("simGetStackInt32Value", stack, Out("int *")) == (1, 5)
    program.done("simPushFloatOntoStack", stack, 0.5)
    assert program.call("simGetStackInt32Value", stack, Out("int *")) == (0, 0)
    assert program.call("simGetStackFloatValue", stack, Out("float *")) == (1, 0.5)
    program.done("simPushStringOntoStack", stack, b"text", 0)
    assert program.call("simGetStackFloatValue", stack, Out("float *"))[0] == 0
    program.done("simReleaseStack", stack)
    assert lib.simReleaseStack(stack) == -1


def test_a_parameter_of_a_user_that_is_missing_stays_missing(program: CProgram) -> None:
    robot = program.handle("robot")
    program.done("simSetUserParameter", robot, b"speed", b"fast", 4)
    assert program.lib.simGetUserParameter(robot, b"speed", ffi.new("int*")) == ffi.NULL


def test_a_line_in_the_log(program: CProgram) -> None:
    assert program.lib.simAddStatusbarMessage(b"hello") == 1


def test_models_and_scenes_are_loaded_and_closed(program: CProgram, tmp_path: Path) -> None:
    lib = program.lib
    model = tmp_path / "model.xml"
    model.write_text(
        '<mujoco model="thing"><worldbody><body name="thing"><geom type="box" size="0.1 0.1 0.1"/></body></worldbody>'
        "</mujoco>"
    )
    base = lib.simLoadModel(str(model).encode())
    assert text(lib.simGetObjectName(base)) == "thing"
    program.done("simLoadScene", str(ROOT / "scenes" / "two_link_arm.xml").encode())
    assert lib.simGetObjectHandle(b"target") > 0
    program.done("simCloseScene")
    assert lib.simGetObjectHandle(b"target") == -1


def test_scenes_and_models_are_saved_and_loaded_again(program: CProgram, tmp_path: Path) -> None:
    lib, crate = program.lib, program.handle("crate")
    scene, model = tmp_path / "scene.ttt", tmp_path / "crate.ttm"
    assert lib.simSaveModel(crate, str(model).encode()) == 1
    assert lib.simSaveScene(str(scene).encode()) == 1
    assert text(lib.simGetObjectName(lib.simLoadModel(str(model).encode()))) == "crate#0"
    program.done("simCloseScene")
    assert lib.simGetObjectHandle(b"crate") == -1
    program.done("simLoadScene", str(scene).encode())
    assert lib.simGetObjectHandle(b"crate") > 0
    assert lib.simGetObjectHandle(b"crate#0") == -1
    assert lib.simSaveScene(str(model / "scene.ttt").encode()) == -1, "its folder is a file"
