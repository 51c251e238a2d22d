"""The compiled physics steps and those in Python give the same numbers, bit for bit."""

from __future__ import annotations

import math
import random
import re
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from random_joints import mechanism
from scenes_for_tests import ARM, world_of
from seeds import seeds

from simx_server.errors import CommandError
from simx_server.files.library import shipped_scenes
from simx_server.joints import JointMode, servo
from simx_server.joints.native import loading
from simx_server.joints.stepping import grip, noslip, separation, sliding, stepper
from simx_server.simulation.simulation import SimulationState
from simx_server.world.world import World

if loading.form().module is None:
    pytest.skip(f"no compiled physics steps: {loading.form().reason}", allow_module_level=True)

from simx_server.joints.native import _physics_step as compiled

Numbers = list[tuple[bytes, ...]]


def disturb(world: World, chance: random.Random) -> None:
    """Give some joints other targets and settings, as clients do."""
    joints = world.simulation.joints
    for handle in list(joints.remember().states):
        binding, state = joints.remember().bindings[handle], joints.remember().states[handle]
        if binding.kind == "ball" or chance.random() < 0.6:
            continue
        try:
            if state.mode == JointMode.FORCE and state.motor and not state.control_loop:
                joints.set_target_velocity(handle, chance.uniform(-3, 3))
            else:
                joints.set_target_position(handle, chance.uniform(-4, 4))
            if chance.random() < 0.2:
                joints.set_max_force(handle, chance.choice((0.0, 0.5, 50.0)))
            if chance.random() < 0.05:
                joints.set_position(handle, chance.uniform(-1, 1))
        except CommandError:
            continue  # it has no such target


def numbers(
    scene: str | Path, form: str, monkeypatch: pytest.MonkeyPatch, steps: int
) -> tuple[Numbers, bool]:
    """Run a scene; return its state after each simulation step, and whether compiled steps were made."""
    monkeypatch.setenv(loading.VARIABLE, form)
    world, chance, found = world_of(scene), random.Random(7), []
    simulation = world.simulation
    simulation.start()
    for number in range(steps):
        if number % 3 == 0:
            disturb(world, chance)
        world.step()
        if not simulation.is_running:  # diverged, in both forms at the same step
            found.append(())
            break
        data, memory = simulation.data, controllers(world).remember()
        arrays = (
            *(data.qpos, data.qvel, data.act, data.ctrl, data.qfrc_constraint, data.xpos, data.xquat),
            *(memory.forces, memory.sensed, memory.of_positions.sums, memory.of_positions.errors),
            *(simulation.model.dof_frictionloss, simulation.model.actuator_biasprm),
        )
        found.append(tuple(each.tobytes() for each in arrays))
    return found, controllers(world)._step is not None


def controllers(world: World) -> stepper.Stepper:
    return world.simulation.joints.controllers.stepper


def assert_equal_in_both_forms(scene: str | Path, monkeypatch: pytest.MonkeyPatch, steps: int) -> None:
    in_python, uses_c = numbers(scene, "python", monkeypatch, steps)
    assert not uses_c
    in_c, _ = numbers(scene, "", monkeypatch, steps)
    assert in_c == in_python


@pytest.mark.parametrize("scene", sorted(shipped_scenes().glob("*.xml")), ids=lambda path: path.stem)
def test_a_shipped_scene_moves_equally_in_both_forms(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert_equal_in_both_forms(scene, monkeypatch, 20)


@pytest.mark.parametrize("seed", seeds(10))
def test_a_random_mechanism_moves_equally_in_both_forms(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    assert_equal_in_both_forms(mechanism(seed), monkeypatch, 24)


FREE = """
<mujoco model="no joints with motors">
  <option integrator="{integrator}" cone="{cone}"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="ball" pos="0 0 0.3"><freejoint/><geom size="0.1" mass="1"/></body>
    <body name="box" pos="0.1 0 0.9"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    {more}
  </worldbody>
  {actuator}
</mujoco>"""

CLOTH = """
<flexcomp type="grid" count="4 4 1" spacing="0.1 0.1 0.1" pos="0 0 1" name="cloth" radius="0.01" mass="0.1">
  <edge equality="true"/>
</flexcomp>"""

SPRING = (
    '<body><joint name="swing"/><geom size="0.1" pos="1 0 1"/></body>',
    '<actuator><position joint="swing" kp="5"/></actuator>',
)


@pytest.mark.parametrize(
    ("integrator", "cone", "more", "actuator"),
    [
        ("Euler", "pyramidal", "", ""),
        ("RK4", "elliptic", "", ""),
        ("implicitfast", "elliptic", "", ""),
        ("implicitfast", "pyramidal", *SPRING),
        ("Euler", "pyramidal", CLOTH, ""),
    ],
    ids=["Euler", "RK4", "elliptic", "a spring", "a flex"],
)
def test_a_scene_without_motors_moves_equally_in_both_forms(
    integrator: str, cone: str, more: str, actuator: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = FREE.format(integrator=integrator, cone=cone, more=more, actuator=actuator)
    assert_equal_in_both_forms(scene, monkeypatch, 20)


# --- where Python has something to do -------------------------------------------------------------


def test_physics_steps_are_compiled_but_where_a_script_is_called_between_them() -> None:
    world = world_of(ARM)
    simulation = world.simulation
    simulation.start()
    world.step()
    assert controllers(world)._step is not None
    called: list[int] = []
    simulation.joints.controllers.accompany(lambda index, _count, _is_over: called.append(index))
    world.step()
    assert controllers(world)._step is None
    assert len(called) == 2 * simulation.substeps
    simulation.joints.controllers.accompany(None)
    world.step()
    assert controllers(world)._step is not None


def test_other_threads_run_during_compiled_steps() -> None:
    """The thread ends the steps, which would go on for a day: it makes the physics diverge."""
    world = world_of(FREE.format(integrator="Euler", cone="pyramidal", more="", actuator=""))
    world.simulation.start()
    world.step()
    step, data = controllers(world)._step, world.simulation.data
    assert step is not None
    started = data.time

    def diverge() -> None:
        while data.time == started:
            pass
        data.qvel[0] = np.nan

    other = threading.Thread(target=diverge)
    other.start()
    made = step.run(0, 10**9, 10**9, 1e9, 0)
    other.join()
    assert 0 < made < 10**9


def test_compiled_steps_end_when_their_time_is_over() -> None:
    world = world_of(ARM)
    world.simulation.start()
    world.step()
    step = controllers(world)._step
    assert step is not None
    assert step.run(0, 10, 10, -1.0, 0) == 1
    assert step.run(1, 10, 10, 1e9, 0) == 10


def test_a_diverging_run_is_stopped_in_compiled_steps(caplog: pytest.LogCaptureFixture) -> None:
    world = world_of(ARM)
    world.simulation.start()
    world.step()
    world.simulation.data.qvel[0] = np.nan
    world.step()
    assert world.simulation.state is SimulationState.STOPPED
    assert "the physics diverged" in caplog.text


# --- the module -----------------------------------------------------------------------------------


def table_of(world: World, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the arguments with which the compiled form of a world's controllers is made."""
    found: dict[str, Any] = {}

    class Module:
        NoRoom = compiled.NoRoom

        @staticmethod
        def PhysicsStep(*arguments: Any) -> Any:
            names = ("model", "data", "table", "friction_rows", "averages_sensors", "grip", "is_immobile")
            found.update(zip(names, arguments, strict=True))
            return compiled.PhysicsStep(**found)

    world.simulation.start()
    monkeypatch.setattr(stepper, "compiled_module", lambda: Module)
    world.step()
    return found


def shortened(table: dict[str, Any]) -> None:
    table["motor.gear"] = table["motor.gear"][:-1]


def beyond_the_model(table: dict[str, Any]) -> None:
    table["position.qpos"] = table["position.qpos"] + 1000


def negative(table: dict[str, Any]) -> None:
    table["motor.ctrl"] = table["motor.ctrl"] - 1000


def beyond_the_rows(table: dict[str, Any]) -> None:
    table["motor.row"] = table["motor.row"] + 1000


def without_force(table: dict[str, Any]) -> None:
    table["mean.force"] = np.zeros(0)


def of_another_kind(table: dict[str, Any]) -> None:
    table["position.gain"] = table["position.gain"].astype(np.float32)


def not_adjacent(table: dict[str, Any]) -> None:
    table["position.gain"] = np.zeros(2 * len(table["position.gain"]))[::2]


def read_only(table: dict[str, Any]) -> None:
    table["position.gain"].flags.writeable = False


def missing(table: dict[str, Any]) -> None:
    del table["still.dof"]


@pytest.mark.parametrize(
    ("break_it", "error", "text"),
    [
        (shortened, ValueError, "motor.gear and motor.ctrl differ in length"),
        (beyond_the_model, IndexError, "position.qpos has an index out of the model"),
        (negative, IndexError, "motor.ctrl has an index out of the model"),
        (beyond_the_rows, IndexError, "a motor has a row beyond"),
        (without_force, ValueError, "do not fit the model"),
        (of_another_kind, TypeError, "position.gain is not a plain array"),
        (not_adjacent, (BufferError, ValueError), "contiguous"),
        (read_only, (BufferError, ValueError), "read-only"),
        (missing, KeyError, "still.dof"),
    ],
)
def test_a_table_that_does_not_fit_is_refused(
    break_it: Callable[[dict[str, Any]], None],
    error: type[Exception],
    text: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    arguments = table_of(world_of(ARM), monkeypatch)
    arguments["table"] = dict(arguments["table"])
    break_it(arguments["table"])
    with pytest.raises(error, match=text):
        compiled.PhysicsStep(**arguments)


def test_anything_but_mujocos_model_and_data_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    arguments = table_of(world_of(ARM), monkeypatch)
    with pytest.raises(TypeError, match="model and data"):
        compiled.PhysicsStep(**{**arguments, "data": arguments["model"]})


@pytest.mark.parametrize("steps", [(-1, 1, 1), (2, 1, 1), (0, 2, 1)])
def test_physics_steps_are_counted_from_0_to_their_number(
    steps: tuple[int, int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    step = compiled.PhysicsStep(**table_of(world_of(ARM), monkeypatch))
    with pytest.raises(ValueError, match="from 0 to count"):
        step.run(*steps, 1.0, 0)


def test_the_flags_are_those_of_the_module() -> None:
    for name in ("LIMIT_SEPARATION", "KEEP_DOWN", "LAST_FORCE", "UPDATE"):
        assert getattr(compiled, name) == getattr(stepper, name)


def test_the_constants_are_those_of_the_form_in_python() -> None:
    defined = dict(re.findall(r"^#define ([A-Z_]+) (\S+)", loading.SOURCE.read_text(), re.MULTILINE))
    for name, value in {
        "DEEP": separation.DEEP,
        "FASTEST": separation.FASTEST,
        "SLIDES": sliding.SLOWEST,
        "TURNS": grip._SLOWEST,
        "IMMOBILE": noslip._IMMOBILE,
        "MOST_VELOCITY": servo.MOST_VELOCITY,
        "LEAST_FORCE": servo._LEAST_FORCE,
        "DAMPING": separation._DAMPING,
        "PI": math.pi,
    }.items():
        assert float(defined[name]) == value, name


@pytest.fixture
def loaded_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the module be judged again, and by the real facts after the test."""
    monkeypatch.setattr(loading, "_load", loading._load.__wrapped__)


@pytest.mark.usefixtures("loaded_again")
def test_a_module_for_another_mujoco_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mujoco, "mj_version", lambda: 4000001)
    assert loading.form() == (
        None,
        f"the module was compiled for MuJoCo {compiled.HEADER}, and 4000001 is running",
    )


@pytest.mark.usefixtures("loaded_again")
def test_a_module_older_than_its_source_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "SOURCE_HASH", "another")
    assert loading.form() == (None, "the compiled module is older than its source")


@pytest.mark.usefixtures("loaded_again")
def test_a_module_that_was_never_compiled_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, f"{loading.__package__}._physics_step", None)
    assert loading.form() == (None, "the build of simx found no C compiler, or no headers of Python")


@pytest.mark.usefixtures("loaded_again")
def test_without_a_function_of_mujoco_the_module_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loading, "_FUNCTIONS", ("mj_step", "mj_noSuchThing"))
    module, reason = loading.form()
    assert module is None
    assert "mj_noSuchThing" in reason


def test_the_variable_leaves_the_module_unused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(loading.VARIABLE, "python")
    assert loading.form() == (None, "SIMX_PHYSICS_STEP is python")
