"""Parameters of objects, of models and of the simulator (the reference's 3.6)."""

from __future__ import annotations

import math
import sys
from typing import Any

import pytest
from conforming import BLOCKING, NO_OBJECT, OK, REMOTE_ERROR, assert_types, of
from real_world import start_stepped, step

import simx_client as v

pytestmark = [pytest.mark.slow, pytest.mark.gl]

NO_PARAMETER = 4242


@of("simxGetObjectFloatParameter")
def test_float_parameters_of_joints_shapes_and_vision_sensors_are_read(
    cid: int, simx: Any, handle: Any
) -> None:
    elbow, cube, colour, crate = (handle(name) for name in ("elbow", "cube", "colour", "crate"))
    assert_types(simx(cid, elbow, v.sim_jointfloatparam_velocity, BLOCKING), (0, 0.0))
    for object_handle, number, value in (
        (elbow, v.sim_jointfloatparam_velocity, 0.0),
        (elbow, v.sim_jointfloatparam_pid_p, 0.1),
        (elbow, v.sim_jointfloatparam_upper_limit, 3.0),
        (cube, v.sim_shapefloatparam_mass, 0.5),
        (colour, v.sim_visionfloatparam_near_clipping, 0.1),
        (colour, v.sim_visionfloatparam_far_clipping, 2.1),
        (colour, v.sim_visionfloatparam_perspective_angle, 2 * math.atan(math.tan(math.radians(30)) * 8 / 6)),
        (crate, v.sim_objfloatparam_objbbox_min_x, -0.1),
        (crate, v.sim_objfloatparam_objbbox_max_y, 0.2),
        (crate, v.sim_objfloatparam_objbbox_max_z, 0.3),
        (crate, v.sim_objfloatparam_modelbbox_max_z, 0.4),
        (cube, v.sim_objfloatparam_abs_z_velocity, 0.0),
    ):
        code, found = simx(cid, object_handle, number, BLOCKING)
        assert (code, found) == (OK, pytest.approx(value, abs=1e-5)), number
    for pair in ((cube, NO_PARAMETER), (cube, v.sim_jointfloatparam_velocity), (NO_OBJECT, 15)):
        assert simx(cid, *pair, BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxGetObjectFloatParameter")
def test_the_measured_velocity_of_joints_and_objects_is_a_parameter(cid: int, simx: Any, handle: Any) -> None:
    start_stepped(cid)
    v.simxSetJointTargetVelocity(cid, handle("shoulder"), 0.5, BLOCKING)
    step(cid, 1.0)
    assert simx(cid, handle("shoulder"), v.sim_jointfloatparam_velocity, BLOCKING)[1] == pytest.approx(
        0.5, abs=0.01
    )
    down = simx(cid, handle("falling"), v.sim_objfloatparam_abs_z_velocity, BLOCKING)[1]
    assert down == pytest.approx(-9.81 * 0.975, rel=0.02)
    turn = simx(cid, handle("upper"), v.sim_objfloatparam_abs_rot_velocity, BLOCKING)[1]
    assert turn == pytest.approx(0.5, abs=0.01)


@of("simxSetObjectFloatParameter")
def test_float_parameters_are_set_and_read_only_ones_are_8(cid: int, simx: Any, handle: Any) -> None:
    elbow, cube, colour = (handle(name) for name in ("elbow", "cube", "colour"))
    for object_handle, number, value in (
        (elbow, v.sim_jointfloatparam_pid_p, 0.25),
        (elbow, v.sim_jointfloatparam_upper_limit, 1.5),
        (cube, v.sim_shapefloatparam_mass, 2.0),
        (colour, v.sim_visionfloatparam_far_clipping, 5.0),
    ):
        assert simx(cid, object_handle, number, value, BLOCKING) == OK
        assert v.simxGetObjectFloatParameter(cid, object_handle, number, BLOCKING) == (OK, value)
    for wrong in (
        (elbow, v.sim_jointfloatparam_velocity),
        (cube, v.sim_objfloatparam_abs_x_velocity),
        (cube, v.sim_objfloatparam_objbbox_max_x),
        (cube, NO_PARAMETER),
        (NO_OBJECT, v.sim_shapefloatparam_mass),
    ):
        assert simx(cid, *wrong, 1.0, BLOCKING) == REMOTE_ERROR


@of("simxGetObjectIntParameter")
def test_integer_parameters_are_read(cid: int, simx: Any, handle: Any) -> None:
    elbow, cube, crate, colour = (handle(name) for name in ("elbow", "cube", "crate", "colour"))
    for object_handle, number, value in (
        (elbow, v.sim_jointintparam_motor_enabled, 1),
        (elbow, v.sim_jointintparam_ctrl_enabled, 1),
        (handle("shoulder"), v.sim_jointintparam_ctrl_enabled, 0),
        (cube, v.sim_shapeintparam_static, 0),
        (crate, v.sim_shapeintparam_static, 1),
        (cube, v.sim_shapeintparam_respondable, 1),
        (crate, v.sim_shapeintparam_respondable, 0),
        (colour, v.sim_visionintparam_resolution_x, 8),
        (colour, v.sim_visionintparam_resolution_y, 6),
    ):
        assert simx(cid, object_handle, number, BLOCKING) == (OK, value), number
    assert_types(simx(cid, elbow, 2000, BLOCKING), (0, 0))
    for pair in ((cube, NO_PARAMETER), (cube, 2000), (NO_OBJECT, 2000)):
        assert simx(cid, *pair, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxSetObjectIntParameter")
def test_integer_parameters_are_set(cid: int, simx: Any, handle: Any) -> None:
    elbow, cube, colour = (handle(name) for name in ("elbow", "cube", "colour"))
    for object_handle, number, value in (
        (elbow, v.sim_jointintparam_ctrl_enabled, 0),
        (elbow, v.sim_jointintparam_motor_enabled, 0),
        (cube, v.sim_shapeintparam_static, 1),
        (cube, v.sim_shapeintparam_respondable, 0),
        (colour, v.sim_visionintparam_resolution_x, 16),
    ):
        assert simx(cid, object_handle, number, value, BLOCKING) == OK
        assert v.simxGetObjectIntParameter(cid, object_handle, number, BLOCKING) == (OK, value)
    assert v.simxGetVisionSensorImage(cid, colour, 0, BLOCKING)[1] == [16, 6]
    for wrong in ((cube, NO_PARAMETER), (NO_OBJECT, 3003)):
        assert simx(cid, *wrong, 1, BLOCKING) == REMOTE_ERROR


@of("simxGetModelProperty")
def test_what_is_no_model_base_has_the_property_0xf000(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, handle("crate"), BLOCKING) == (OK, 0)
    assert simx(cid, handle("lid"), BLOCKING) == (OK, v.sim_modelproperty_not_model)
    assert_types(simx(cid, handle("lid"), BLOCKING), (0, 0))
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxSetModelProperty")
def test_a_model_base_is_made_and_unmade_and_its_bits_kept(cid: int, simx: Any, handle: Any) -> None:
    cube = handle("cube")
    bits = v.sim_modelproperty_not_visible | v.sim_modelproperty_not_collidable
    assert simx(cid, cube, bits, BLOCKING) == OK
    assert v.simxGetModelProperty(cid, cube, BLOCKING) == (OK, bits)
    assert simx(cid, cube, 0x1000, BLOCKING) == OK
    assert v.simxGetModelProperty(cid, cube, BLOCKING) == (OK, 0xF000)
    assert v.simxRemoveModel(cid, cube, BLOCKING) == REMOTE_ERROR
    assert simx(cid, cube, 0, BLOCKING) == OK
    assert v.simxRemoveModel(cid, cube, BLOCKING) == OK
    assert simx(cid, NO_OBJECT, 0, BLOCKING) == REMOTE_ERROR


@of("simxSetModelProperty")
def test_sensors_go_on_when_a_part_of_a_restricted_model_is_removed(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, handle("crate"), v.sim_modelproperty_not_visible, BLOCKING) == OK
    assert v.simxRemoveObject(cid, handle("lid"), BLOCKING) == OK
    start_stepped(cid)
    step(cid, 0.05)
    assert v.simxReadProximitySensor(cid, handle("ahead"), BLOCKING)[0] == OK


@of("simxGetBooleanParameter")
def test_boolean_parameters_are_bool_and_unknown_ones_8(cid: int, simx: Any) -> None:
    for number, value in (
        (v.sim_boolparam_dynamics_handling_enabled, True),
        (v.sim_boolparam_proximity_sensor_handling_enabled, True),
        (v.sim_boolparam_vision_sensor_handling_enabled, True),
        (v.sim_boolparam_collision_handling_enabled, True),
        (v.sim_boolparam_distance_handling_enabled, True),
        (v.sim_boolparam_headless, True),
        (v.sim_boolparam_waiting_for_trigger, False),
        (v.sim_boolparam_realtime_simulation, False),
    ):
        assert simx(cid, number, BLOCKING) == (OK, value), number
    assert_types(simx(cid, v.sim_boolparam_headless, BLOCKING), (0, True))
    assert simx(cid, NO_PARAMETER, BLOCKING) == (REMOTE_ERROR, False)


@of("simxSetBooleanParameter")
def test_a_window_may_be_switched_off_and_cannot_be_switched_on(cid: int, simx: Any) -> None:
    for number in (v.sim_boolparam_display_enabled, v.sim_boolparam_browser_visible):
        assert simx(cid, number, False, BLOCKING) == OK
        assert v.simxGetBoolParam(cid, number, BLOCKING) == (OK, False)
        assert simx(cid, number, True, BLOCKING) == REMOTE_ERROR


@of("simxSetBooleanParameter")
def test_real_time_is_settable_only_while_stopped_and_success_otherwise(cid: int, simx: Any) -> None:
    real_time = v.sim_boolparam_realtime_simulation
    assert simx(cid, real_time, True, BLOCKING) == OK
    assert v.simxGetBoolParam(cid, real_time, BLOCKING) == (OK, True)
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, real_time, False, BLOCKING) == OK
    assert v.simxGetBoolParam(cid, real_time, BLOCKING) == (OK, True)
    assert simx(cid, NO_PARAMETER, True, BLOCKING) == REMOTE_ERROR
    assert simx(cid, v.sim_boolparam_headless, False, BLOCKING) == REMOTE_ERROR, "read only"


@of("simxSetBooleanParameter")
def test_dynamics_switched_off_hold_everything_still(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, v.sim_boolparam_dynamics_handling_enabled, False, BLOCKING) == OK
    start_stepped(cid)
    step(cid, 0.2)
    assert v.simxGetObjectPosition(cid, handle("falling"), -1, BLOCKING) == (OK, [2.0, 1.0, 50.0])


@of("simxGetIntegerParameter")
def test_integer_parameters_of_the_simulator(cid: int, simx: Any) -> None:
    platform = {"win32": 0, "darwin": 1}.get(sys.platform, 2)
    assert simx(cid, v.sim_intparam_platform, BLOCKING) == (OK, platform)
    assert simx(cid, v.sim_intparam_edit_mode_type, BLOCKING) == (OK, 0)
    assert simx(cid, v.sim_intparam_program_version, BLOCKING)[1] >= 30000
    assert_types(simx(cid, v.sim_intparam_platform, BLOCKING), (0, 0))
    before = simx(cid, v.sim_intparam_stop_request_counter, BLOCKING)[1]
    v.simxStartSimulation(cid, BLOCKING)
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, v.sim_intparam_stop_request_counter, BLOCKING)[1] > before
    scene = simx(cid, v.sim_intparam_scene_unique_id, BLOCKING)[1]
    v.simxCloseScene(cid, BLOCKING)
    assert simx(cid, v.sim_intparam_scene_unique_id, BLOCKING)[1] != scene
    assert simx(cid, NO_PARAMETER, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxSetIntegerParameter")
def test_read_only_integer_parameters_are_8(cid: int, simx: Any) -> None:
    assert simx(cid, v.sim_intparam_error_report_mode, 0, BLOCKING) == OK
    assert v.simxGetInt32Param(cid, v.sim_intparam_error_report_mode, BLOCKING) == (OK, 0)
    for number in (v.sim_intparam_program_version, v.sim_intparam_platform, NO_PARAMETER):
        assert simx(cid, number, 1, BLOCKING) == REMOTE_ERROR


@of("simxGetFloatingParameter")
def test_float_parameters_of_the_simulator(cid: int, simx: Any) -> None:
    code, step_length = simx(cid, v.sim_floatparam_simulation_time_step, BLOCKING)
    assert (code, type(step_length)) == (OK, float)
    assert step_length == pytest.approx(0.05, abs=1e-7)
    drawn = [simx(cid, v.sim_floatparam_rand, BLOCKING)[1] for _ in range(5)]
    assert all(0 <= value <= 1 for value in drawn)
    assert len(set(drawn)) > 1
    assert simx(cid, NO_PARAMETER, BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxSetFloatingParameter")
def test_the_time_step_is_set_while_stopped_and_ignored_with_success_while_running(
    cid: int, simx: Any
) -> None:
    step_id = v.sim_floatparam_simulation_time_step
    assert simx(cid, step_id, 0.01, BLOCKING) == OK
    start_stepped(cid)
    v.simxSynchronousTrigger(cid)
    v.simxGetPingTime(cid)
    assert v.simxGetLastCmdTime(cid) == 10
    assert simx(cid, step_id, 0.1, BLOCKING) == OK
    assert v.simxGetFloatParam(cid, step_id, BLOCKING)[1] == pytest.approx(0.01)
    assert simx(cid, NO_PARAMETER, 1.0, BLOCKING) == REMOTE_ERROR


@of("simxGetStringParameter")
def test_string_parameters_of_the_simulator(cid: int, simx: Any) -> None:
    code, path = simx(cid, v.sim_stringparam_scene_path_and_name, BLOCKING)
    assert (code, type(path)) == (OK, str)
    assert path.endswith("scene.xml")
    assert simx(cid, v.sim_stringparam_application_path, BLOCKING)[0] == OK
    assert simx(cid, NO_PARAMETER, BLOCKING) == (REMOTE_ERROR, "")


@of("simxGetArrayParameter")
def test_array_parameters_have_three_floats(cid: int, simx: Any) -> None:
    assert simx(cid, v.sim_arrayparam_gravity, BLOCKING)[1] == pytest.approx([0, 0, -9.81])
    assert_types(simx(cid, v.sim_arrayparam_gravity, BLOCKING), (0, [0.0]))
    assert len(simx(cid, v.sim_arrayparam_random_euler, BLOCKING)[1]) == 3
    assert simx(cid, NO_PARAMETER, BLOCKING) == (REMOTE_ERROR, [0.0] * 3)


@of("simxSetArrayParameter")
def test_gravity_is_set_and_random_angles_are_read_only(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, v.sim_arrayparam_gravity, (0.0, 0.0, 0.0), BLOCKING) == OK
    assert v.simxGetArrayParam(cid, v.sim_arrayparam_gravity, BLOCKING) == (OK, [0.0] * 3)
    start_stepped(cid)
    step(cid, 0.2)
    assert v.simxGetObjectPosition(cid, handle("falling"), -1, BLOCKING)[1][2] == pytest.approx(50)
    assert simx(cid, v.sim_arrayparam_random_euler, [0, 0, 0], BLOCKING) == REMOTE_ERROR
    assert simx(cid, NO_PARAMETER, [0, 0, 0], BLOCKING) == REMOTE_ERROR
