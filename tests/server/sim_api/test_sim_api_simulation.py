"""The simulation, its clock, its parameters and random numbers, as scripts see and steer them."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim_api_calls import SCENE, ScriptWorld, world

from simx_server.parts.communication.semaphores import Semaphores
from simx_server.simulation.simulation import SimulationState

__all__ = ["world"]


def test_time_and_state(world: ScriptWorld) -> None:
    assert world.value("sim.getSimulationState() == sim.simulation_advancing_firstafterstop") is True
    world.passes(3)
    assert world.value("sim.getSimulationTime()") == pytest.approx(0.15)
    assert world.value("sim.getSimulationTimeStep()") == pytest.approx(0.05)
    assert world.value("sim.getSimulationState() == sim.simulation_advancing_running") is True
    world.call("simxPauseSimulation")
    assert world.value("sim.getSimulationState() == sim.simulation_paused") is True
    world.fails("sim.setSimulationTimeStep(0.01)", "only while the simulation is stopped")


def test_a_stop_waits_for_the_end_of_the_step(world: ScriptWorld) -> None:
    assert world.value("sim.stopSimulation()") == 1
    assert world.sim.state is SimulationState.RUNNING
    assert world.value("sim.getSimulationState() == sim.simulation_advancing_abouttostop") is True
    assert world.value("sim.getSimulationStopping()") is True
    world.passes()
    assert world.sim.state is SimulationState.STOPPED
    assert not world.sim.is_stopping


def test_a_pause_and_what_follows_it(world: ScriptWorld) -> None:
    assert world.value("sim.getSimulationStopping()") is False
    assert world.value("sim.pauseSimulation()") == 1
    world.passes()
    assert world.sim.state is SimulationState.PAUSED
    assert world.value("sim.startSimulation()") == 1
    world.sim.settle()
    assert world.sim.state is SimulationState.RUNNING


def test_the_server_ends_only_while_stopped(world: ScriptWorld) -> None:
    world.goes_on("sim.quitSimulator()", "only while the simulation is stopped", -1)


def test_scenes_are_changed_only_while_stopped(world: ScriptWorld) -> None:
    world.fails("sim.loadScene('scene.xml')", "only while the simulation is stopped")
    world.goes_on("sim.closeScene()", "a scene can be closed only while the simulation is stopped", -1)
    assert world.value("sim.announceSceneContentChange()") == 0


def test_a_customization_script_changes_the_scene_when_it_is_through(tmp_path: Path) -> None:
    (tmp_path / "other.xml").write_text(
        "<mujoco><worldbody><body name='other'><geom size='1'/></body></worldbody></mujoco>"
    )
    world = ScriptWorld(tmp_path, kind="customization")
    world.call("simxStopSimulation")
    scene = world.sim.scene
    assert world.value("sim.loadScene('other.xml')") == 1
    assert world.sim.scene is scene
    world.sim.settle()
    assert world.handle("other")


@pytest.mark.parametrize("call", ["sim.closeScene()", "sim.loadScene('')"])
def test_a_customization_script_starts_and_closes(tmp_path: Path, call: str) -> None:
    world = ScriptWorld(tmp_path, kind="customization")
    world.call("simxStopSimulation")
    world.lua("sim.setSimulationTimeStep(0.1); sim.startSimulation()")
    world.sim.settle()
    assert world.sim.state is SimulationState.RUNNING
    assert world.value("sim.getSimulationTimeStep()") == 0.1
    world.lua("sim.stopSimulation()")
    world.sim.settle()
    assert world.sim.state is SimulationState.STOPPED
    assert world.value(call) == 1
    world.sim.settle()
    assert world.handle("ResizableFloor_5_25") in world.sim.scene.objects
    assert world.sim.scene.by_name("hinge") is None


def test_a_thread_of_a_customization_script_waits_for_the_stop(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, kind="customization")
    world.lua("thread = coroutine.create(function() result = sim.stopSimulation(true) end)")
    assert world.lua("return coroutine.resume(thread), result") == [True, None]
    world.sim.settle()
    assert world.lua("return coroutine.resume(thread), result") == [True, 1]


def test_a_script_that_ends_with_the_run_cannot_wait_for_the_stop(world: ScriptWorld) -> None:
    world.fails(
        "sim.stopSimulation(true)", "a child script ends with the run, so it cannot wait for the stop"
    )


def test_clocks_of_the_wall(world: ScriptWorld) -> None:
    first, second = world.value("sim.getSystemTime()"), world.value("sim.getSystemTime()")
    assert 0 < first <= second
    earlier = world.value("sim.getSystemTimeInMilliseconds(-1)")
    assert 0 <= world.value(f"sim.getSystemTimeInMs({earlier})") < 60_000
    assert world.value("sim.getRealTimeSimulation()") == 0
    assert world.value("sim.isRealTimeSimulationStepNeeded()") == 1
    assert world.value("sim.getSimulationPassesPerRenderingPass()") == 1
    world.lua("sim.adjustRealTimeTimer(0, 0.1)")


def test_random_numbers_are_the_same_in_every_run(world: ScriptWorld) -> None:
    first = world.lua("return sim.getRandom(), sim.getRandom()")
    assert first[0] != first[1]
    assert all(0 <= number < 1 for number in first)
    world.call("simxStopSimulation")
    world.call("simxStartSimulation")
    assert world.lua("return sim.getRandom(), sim.getRandom()") == first
    assert world.value("sim.getRandom(5)") == world.value("sim.getRandom(5)") != first[0]


NEW_NAMES = """
sim.setBoolParam(sim.boolparam_collision_handling_enabled, false)
sim.setInt32Param(sim.intparam_visible_layers, 3)
sim.setFloatParam(sim.floatparam_simulation_time_step, 0.1)
sim.setArrayParam(sim.arrayparam_gravity, {0, 0, -1})
return sim.getBoolParam(sim.boolparam_headless), sim.getBoolParam(sim.boolparam_collision_handling_enabled),
    sim.getInt32Param(sim.intparam_program_version), sim.getInt32Param(sim.intparam_visible_layers),
    sim.getFloatParam(sim.floatparam_simulation_time_step), sim.getStringParam(sim.stringparam_scene_name),
    sim.getArrayParam(sim.arrayparam_gravity)
"""

OLD_NAMES = """
sim.setBoolParameter(sim.boolparam_collision_handling_enabled, false)
sim.setInt32Parameter(sim.intparam_visible_layers, 3)
sim.setFloatParameter(sim.floatparam_simulation_time_step, 0.1)
sim.setArrayParameter(sim.arrayparam_gravity, {0, 0, -1})
return sim.getBoolParameter(sim.boolparam_headless), sim.getBoolParameter(sim.boolparam_collision_handling_enabled),
    sim.getInt32Parameter(sim.intparam_program_version), sim.getInt32Parameter(sim.intparam_visible_layers),
    sim.getFloatParameter(sim.floatparam_simulation_time_step), sim.getStringParameter(sim.stringparam_scene_name),
    sim.getArrayParameter(sim.arrayparam_gravity)
"""


@pytest.mark.parametrize("script", [NEW_NAMES, OLD_NAMES])
def test_parameters_by_new_and_old_names(world: ScriptWorld, script: str) -> None:
    assert world.lua(script) == [True, False, 30602, 3, pytest.approx(0.05), "scene", [0, 0, -1]]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("sim.setStringParam(sim.stringparam_scene_name, 'x')", "string parameter 15 cannot be set"),
        ("sim.setStringParameter(sim.stringparam_scene_name, 'x')", "string parameter 15 cannot be set"),
        ("sim.setArrayParam(sim.arrayparam_gravity, {1})", "an array parameter is 3 numbers, not 1"),
        ("sim.getInt32Param(9999)", "integer parameter 9999 cannot be read; those that can"),
    ],
)
def test_parameters_that_are_not_there_are_refused(world: ScriptWorld, call: str, message: str) -> None:
    world.fails(call, message)


def test_the_oldest_names_of_parameters(world: ScriptWorld) -> None:
    world.lua("sim.setBooleanParameter(sim.boolparam_distance_handling_enabled, false)")
    assert world.value("sim.getBooleanParameter(sim.boolparam_distance_handling_enabled)") is False
    world.lua("sim.setIntegerParameter(sim.intparam_visible_layers, 5)")
    assert world.value("sim.getIntegerParameter(sim.intparam_visible_layers)") == 5
    world.lua("sim.setFloatingParameter(sim.floatparam_simulation_time_step, 0.1)")
    assert world.value("sim.getFloatingParameter(sim.floatparam_simulation_time_step)") == pytest.approx(0.05)


SET_STEP = "return sim.setFloatParam(sim.floatparam_simulation_time_step, {}), sim.getSimulationTimeStep()"


@pytest.mark.parametrize(
    ("note", "wanted", "step"),
    [("yes", 0.02, 0.02), ("yes", 50.0, 10.0), ("yes", 1e-9, 1e-4), ("no", 50.0, 0.05), ("no", 0.02, 0.05)],
)
def test_a_simulation_step_is_limited_and_stays_where_it_is_not_custom(
    tmp_path: Path, note: str, wanted: float, step: float
) -> None:
    """As in CoppeliaSim 4.1, where PyRep asks for 50 s, gets the result 1 and reads the step again."""
    xml = SCENE.replace("</custom>", f'<text name="simx:scene:world" data="custom_step={note}"/></custom>')
    world = ScriptWorld(tmp_path, xml, kind="customization")
    assert world.lua(SET_STEP.format(wanted)) == [0, pytest.approx(0.05)]  # during a run
    world.call("simxStopSimulation")
    assert world.lua(SET_STEP.format(wanted)) == [1, pytest.approx(step)]


def test_named_parameters(world: ScriptWorld) -> None:
    assert world.value("sim.getNamedStringParam('mine.level')") is None
    world.lua("sim.setNamedStringParam('mine.level', '3')")
    assert world.value("sim.getNamedStringParam('mine.level')") == "3"
    assert world.value("sim.readCustomDataBlockTags(sim.handle_app)") is None


def test_friction_by_the_names_of_every_engine(world: ScriptWorld) -> None:
    world.lua("cube = sim.getObject('cube')")
    for name in (
        "bullet_body_friction",
        "ode_body_friction",
        "newton_body_staticfriction",
        "mujoco_body_friction1",
    ):
        assert world.value(f"sim.setEngineFloatParam(sim.{name}, cube, 0.25)") == 1
        assert world.value("sim.getEngineFloatParam(sim.vortex_body_primlinearaxisfriction, cube)") == 0.25
        assert world.value(f"sim.setEngineFloatParameter(sim.{name}, cube, 0.5)") == 1
        assert world.value(f"sim.getEngineFloatParameter(sim.{name}, cube)") == 0.5
    world.lua("sim.createDummy(0.1)")
    assert world.value("sim.getEngineFloatParam(sim.bullet_body_friction, cube)") == 0.5, "an edit keeps it"
    world.fails(
        "sim.setEngineFloatParam(sim.bullet_body_friction, cube, -1)", "a friction must not be below 0"
    )
    world.fails("sim.getEngineFloatParam(sim.bullet_body_friction, -1)", "no object with handle -1")
    world.call("simxStopSimulation")
    assert world.sim.model.geom_friction[world.sim.model.body("cube").geomadr[0], 0] == 1


def test_the_engines_own_parameters(world: ScriptWorld) -> None:
    world.lua("cube = sim.getObject('cube')")
    assert world.value("sim.getEngineFloatParam(sim.mujoco_global_stepsize, -1)") == 0.005
    world.lua("sim.setEngineFloatParam(sim.mujoco_global_density, -1, 1.2)")
    assert world.sim.model.opt.density == 1.2
    world.lua("sim.setEngineFloatParam(sim.mujoco_global_wind2, -1, -3)")
    assert world.sim.model.opt.wind.tolist() == [0, -3, 0]
    world.lua("sim.setEngineInt32Param(sim.mujoco_body_condim, cube, 4); sim.createDummy(0.1)")
    assert world.value("sim.getEngineInt32Param(sim.mujoco_body_condim, cube)") == 4
    assert world.value("sim.setEngineInt32Parameter(sim.mujoco_global_iterations, -1, 50)") == 1
    assert world.value("sim.getEngineInt32Parameter(sim.mujoco_global_iterations)") == 50
    world.lua("sim.setEngineFloatParam(sim.mujoco_body_solref1, cube, 0.05)")
    assert world.value("sim.getEngineFloatParam(sim.mujoco_body_solref1, cube)") == pytest.approx(0.05)
    world.fails(
        "sim.setEngineInt32Param(sim.mujoco_body_condim, cube, 2)", "a contact has 1, 3, 4 or 6 dimensions"
    )
    world.goes_on("sim.setEngineFloatParam(sim.mujoco_global_stepsize, -1, 1)", "can only be read", 1)
    world.fails("sim.setEngineFloatParam(sim.mujoco_global_density, -1, -1)", "must not be below 0")


def test_parameters_of_other_engines_are_kept_without_effect(world: ScriptWorld) -> None:
    world.goes_on("sim.setEngineFloatParam(sim.ode_body_softerp, 1, 0.5)", "15002 has no effect here", 1)
    assert world.value("sim.getEngineFloatParam(sim.ode_body_softerp, 1)") == 0.5
    assert world.value("sim.getEngineFloatParam(sim.ode_body_softerp, 2)") == 0.0
    for name in ("Param", "Parameter"):
        assert world.value(f"sim.setEngineBool{name}(sim.bullet_body_sticky, 1, true)") == 1
        assert world.value(f"sim.getEngineBool{name}(sim.bullet_body_sticky, 1)") is True
    world.fails("sim.getEngineFloatParam(4711, 1)", "the engine, MuJoCo, has no float parameter 4711; it has")


def test_named_parameters_are_read_as_other_types(world: ScriptWorld) -> None:
    assert (
        world.value("sim.getNamedFloatParam('mine') == nil and sim.getNamedBoolParam('mine') == nil") is True
    )
    assert world.value("sim.setNamedFloatParam('mine', 2.5)") == 1
    assert world.value("sim.setNamedFloatParam('mine', 2)") == 0
    assert world.lua(
        "return sim.getNamedFloatParam('mine'), sim.getNamedInt32Param('mine'), sim.getNamedBoolParam('mine')"
    ) == [2.0, 2, True]
    world.lua("sim.setNamedBoolParam('mine', false) sim.setNamedInt32Param('count', 7)")
    assert world.lua("return sim.getNamedBoolParam('mine'), sim.getSettingInt32('count')") == [False, 7]
    assert world.value("sim.getNamedFloatParam('mine') == nil") is True
    assert world.value("sim.getStringNamedParam('mine')") == "false"
    world.lua("sim.setStringNamedParam('mine', ' On ')")
    assert world.lua("return sim.getSettingBool('mine'), sim.getSettingString('mine')") == [True, " On "]


def test_stored_data_are_found_by_a_pattern(world: ScriptWorld) -> None:
    world.lua(
        "for _, name in ipairs{'arm.speed', 'arm.size', 'leg'} do sim.persistentDataWrite(name, 'x') end"
    )
    found = "sim.getMatchingPersistentDataTags"
    assert world.value(f"{found}('arm\\\\.s')") == ["arm.speed", "arm.size"]
    assert world.value(f"{found}('^l.g$')") == ["leg"]
    assert world.value(f"{found}('a.*d')") == ["arm.speed"]
    for pattern in ("(a+)+", "a**", ".*.*.*.*", "[a]"):
        world.fails(f"{found}('{pattern}')", "is not a pattern of characters")


def test_a_semaphore_is_held_by_one_simulation(world: ScriptWorld, tmp_path: Path) -> None:
    key = tmp_path.name + str(tmp_path.stat().st_ino)
    other = Semaphores()
    assert other.acquire(key)
    world.fails(f"sim.systemSemaphore('{key}', true)", "only in a thread")
    world.fails(f"sim.systemSemaphore('{key}', false)", "has not acquired the semaphore")
    world.lua(
        f"waiting = coroutine.create(function() sim.systemSemaphore('{key}', true) got = true end) "
        "coroutine.resume(waiting)"
    )
    assert world.value("got == nil") is True
    other.release(key)
    world.lua("coroutine.resume(waiting)")
    assert world.value("got") is True
    assert not other.acquire(key)
    world.lua(f"sim.systemSemaphore('{key}', false)")
    assert other.acquire(key)
    other.release(key)


def test_names_of_other_versions_of_coppeliasim_answer(world: ScriptWorld) -> None:
    assert world.lua(
        "return sim.getIsRealTimeSimulation() == sim.getRealTimeSimulation(), sim.boolAnd(6, 3), sim.boolXor(6, 3)"
    ) == [True, 2, 5]
    assert world.lua("return sim.getLastInfo(), sim.isDeprecated('sim.boolAnd')") == ["", 0]
    world.lua("sim.fastIdleLoop(true)")
    world.lua(
        "cube = sim.getObject('cube') group = sim.createCollectionEx(0) sim.addToCollection(group, cube)"
    )
    assert world.value("sim.getCollectionObjects(group)") == [world.handle("cube")]
    assert world.value("sim.getObjectFloatArrayParam(cube, 7) == nil") is True
    world.fails("sim.setObjectFloatArrayParam(cube, 7, {1})", "no parameter 7 that is a list of numbers")
