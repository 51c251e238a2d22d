"""Functions of objects, poses and joints, called as PyRep calls them."""

from __future__ import annotations

import math

import pytest
from c_program import CProgram, Out, ffi, numbers, text

from simx_client.protocol import constants as c

ROBOT_SHAPES = 3
MODEL = c.sim_modelproperty_not_dynamic
VECTOR, ANGLES = Out("float[3]"), Out("float[3]")


def single(number: float) -> float:
    return ffi.new("float *", number)[0]


def test_names_and_handles_lead_to_each_other(program: CProgram) -> None:
    lib, cube = program.lib, program.handle("cube")
    assert text(lib.simGetObjectName(cube)) == "cube"
    program.done("simSetObjectName", cube, b"block")
    assert lib.simGetObjectHandle(b"block") == cube
    assert lib.simGetObjectHandle(b"cube") == -1
    assert lib.simGetObjectType(cube) == c.sim_object_shape_type
    listed = [lib.simGetObjects(index, c.sim_object_shape_type) for index in range(50)]
    assert cube in listed
    assert listed[-1] == -1


def test_a_tree_is_listed_with_its_length(program: CProgram) -> None:
    robot = program.handle("robot")
    pointer, count = program.call("simGetObjectsInTree", robot, c.sim_object_joint_type, 1, Out("int *"))
    assert numbers(pointer, count) == [program.handle("shoulder"), program.handle("elbow")]
    pointer, count = program.call("simGetObjectsInTree", program.handle("target"), -2, 1, Out("int *"))
    assert pointer != ffi.NULL, "an empty list is no failure"
    assert count == 0
    assert program.lib.simReleaseBuffer(ffi.cast("char *", pointer)) == 1


def test_parents_and_children(program: CProgram) -> None:
    lib, crate, lid, cube = (
        program.lib,
        program.handle("crate"),
        program.handle("lid"),
        program.handle("cube"),
    )
    assert lib.simGetObjectParent(lid) == crate
    assert lib.simGetObjectChild(crate, 0) == lid
    before = program.done("simGetObjectPosition", cube, -1, VECTOR)
    program.done("simSetObjectParent", cube, crate, True)
    assert lib.simGetObjectParent(cube) == crate
    assert program.done("simGetObjectPosition", cube, -1, VECTOR) == pytest.approx(before, abs=1e-6)


def test_objects_are_made_copied_and_removed(program: CProgram) -> None:
    lib = program.lib
    dummy = lib.simCreateDummy(0.05, ffi.NULL)
    assert lib.simGetObjectType(dummy) == c.sim_object_dummy_type
    handles = ffi.new("int[]", [program.handle("cube")])
    program.done("simCopyPasteObjects", handles, 1, 0)
    assert text(lib.simGetObjectName(handles[0])) == "cube#0"
    for each in (dummy, handles[0]):
        program.done("simRemoveObject", each)
        assert lib.simGetObjectName(each) == ffi.NULL
    program.done("simRemoveModel", program.handle("crate"))
    assert lib.simGetObjectHandle(b"lid") == -1


def test_sizes(program: CProgram) -> None:
    cube, falling = program.handle("cube"), program.handle("falling")
    program.done("simScaleObject", cube, 2.0, 2.0, 2.0, 0)
    largest, size = program.call(
        "simGetObjectFloatParameter", cube, c.sim_objfloatparam_objbbox_max_x, Out("float *")
    )
    assert largest == 1
    assert size == pytest.approx(0.2)
    program.done("simScaleObjects", ffi.new("int[]", [falling]), 1, 3.0, False)
    assert program.lib.simGetObjectSizeFactor(falling) == 3.0


def test_properties_of_models_and_objects(program: CProgram) -> None:
    lib, robot, cube = program.lib, program.handle("robot"), program.handle("cube")
    before = lib.simGetModelProperty(robot)
    program.done("simSetModelProperty", robot, before | MODEL)
    assert lib.simGetModelProperty(robot) == before | MODEL
    special = lib.simGetObjectSpecialProperty(cube)
    assert special & c.sim_objectspecialproperty_collidable
    program.done("simSetObjectSpecialProperty", cube, special & ~c.sim_objectspecialproperty_collidable)
    assert not lib.simGetObjectSpecialProperty(cube) & c.sim_objectspecialproperty_collidable


def test_parameters_of_objects_fail_with_zero(program: CProgram) -> None:
    lib, cube = program.lib, program.handle("cube")
    assert lib.simSetObjectInt32Parameter(cube, c.sim_shapeintparam_respondable, 0) == 1
    assert program.call(
        "simGetObjectInt32Parameter", cube, c.sim_shapeintparam_respondable, Out("int *")
    ) == (1, 0)
    assert lib.simSetObjectFloatParameter(cube, c.sim_shapefloatparam_mass, 0.7) == 1
    assert program.call("simGetObjectFloatParameter", cube, c.sim_shapefloatparam_mass, Out("float *")) == (
        1,
        single(0.7),
    )
    for name in ("Int32", "Float"):
        assert getattr(lib, f"simSetObject{name}Parameter")(cube, 99999, 1) == 0
        assert program.call(f"simGetObject{name}Parameter", cube, 99999, Out("int *"))[0] == 0


def test_extension_strings_and_explicit_handling(program: CProgram) -> None:
    lib, sensor = program.lib, program.handle("by_hand")
    assert lib.simGetExtensionString(sensor, -1, b"") == ffi.NULL
    assert lib.simGetExplicitHandling(sensor) == 1
    program.done("simSetExplicitHandling", sensor, 0)
    assert lib.simGetExplicitHandling(sensor) == 0


def test_a_configuration_is_opaque_bytes_that_restore_poses(program: CProgram) -> None:
    lib, cube = program.lib, program.handle("cube")
    configuration = lib.simGetConfigurationTree(cube)
    before = program.done("simGetObjectPosition", cube, -1, VECTOR)
    program.done("simSetObjectPosition", cube, -1, [0.0, 0.0, 5.0])
    program.done("simSetConfigurationTree", configuration)
    assert program.done("simGetObjectPosition", cube, -1, VECTOR) == pytest.approx(before, abs=1e-6)


def test_poses_in_four_forms(program: CProgram) -> None:
    cube, crate = program.handle("cube"), program.handle("crate")
    program.done("simSetObjectPosition", cube, crate, (0.1, 0.2, 0.3))
    assert program.done("simGetObjectPosition", cube, crate, VECTOR) == [single(x) for x in (0.1, 0.2, 0.3)]
    program.done("simSetObjectOrientation", cube, -1, [0.0, 0.0, math.pi / 2])
    assert program.done("simGetObjectOrientation", cube, -1, ANGLES)[2] == pytest.approx(math.pi / 2)
    half = math.sqrt(0.5)
    assert program.done("simGetObjectQuaternion", cube, -1, Out("float[4]")) == pytest.approx(
        [0, 0, half, half]
    )
    program.done("simSetObjectQuaternion", cube, -1, [0.0, 0.0, 0.0, 1.0])
    assert program.done("simGetObjectMatrix", cube, -1, Out("float[12]"))[:3] == pytest.approx(
        [1, 0, 0], abs=1e-6
    )
    program.done("simSetObjectMatrix", cube, -1, [1, 0, 0, 4, 0, 1, 0, 5, 0, 0, 1, 6])
    assert program.done("simGetObjectPosition", cube, -1, VECTOR) == [4, 5, 6]


def test_matrices_are_turned_inverted_and_multiplied(program: CProgram) -> None:
    unit = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
    turned = program.done("simRotateAroundAxis", unit, [0, 0, 1], [0, 0, 0], math.pi / 2, Out("float[12]"))
    assert program.done("simGetEulerAnglesFromMatrix", turned, ANGLES) == pytest.approx(
        [0, 0, math.pi / 2], abs=1e-6
    )
    inverse = ffi.new("float []", turned)
    program.done("simInvertMatrix", inverse)
    product = program.done("simMultiplyMatrices", turned, list(inverse), Out("float[12]"))
    assert product == pytest.approx(unit, abs=1e-6)


def test_velocities_of_a_falling_object(program: CProgram) -> None:
    falling = program.handle("falling")
    program.run(10)
    _, linear, angular = program.call("simGetObjectVelocity", falling, VECTOR, VECTOR)
    assert linear[2] == pytest.approx(-9.81 * 10 * program.lib.simGetSimulationTimeStep(), rel=0.1)
    assert angular == pytest.approx([0, 0, 0], abs=1e-6)
    program.done("simResetDynamicObject", falling)
    program.lib.simExtStep(True)
    assert program.call("simGetObjectVelocity", falling, VECTOR, VECTOR)[1][2] > -0.6, "it falls anew"


def test_joints_tell_their_type_mode_and_interval(program: CProgram) -> None:
    lib, shoulder, elbow, rail = program.lib, *map(program.handle, ("shoulder", "elbow", "rail"))
    assert lib.simGetJointType(shoulder) == c.sim_joint_revolute_subtype
    assert lib.simGetJointType(rail) == c.sim_joint_prismatic_subtype
    assert program.call("simGetJointMode", shoulder, Out("int*"))[0] == c.sim_jointmode_force
    program.done("simSetJointMode", rail, c.sim_jointmode_ik, 0)
    assert program.call("simGetJointMode", rail, Out("int*"))[0] == c.sim_jointmode_ik
    _, cyclic, _ = program.call("simGetJointInterval", shoulder, Out("char *"), Out("float [2]"))
    assert cyclic == b"\1"
    _, cyclic, interval = program.call("simGetJointInterval", elbow, Out("char *"), Out("float [2]"))
    assert (cyclic, interval) == (b"\0", [-2.0, 4.0])
    program.done("simSetJointInterval", elbow, False, [-1.0, 1.5])
    assert program.call("simGetJointInterval", elbow, Out("char *"), Out("float [2]"))[2] == [-1.0, 1.5]


def test_joints_are_placed_at_once(program: CProgram) -> None:
    elbow = program.handle("elbow")
    program.run(1)
    program.done("simSetJointPosition", elbow, 0.5)
    assert program.done("simGetJointPosition", elbow, Out("float *")) == 0.5
    assert program.done("simGetJointMatrix", elbow, Out("float[12]")) != []


def test_a_spherical_joint_is_turned_by_a_matrix(program: CProgram) -> None:
    ball = program.handle("ball")
    turned = [0.0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]
    program.done("simSetSphericalJointMatrix", ball, turned)
    assert program.done("simGetJointMatrix", ball, Out("float[12]")) == pytest.approx(turned, abs=1e-6)


def test_motors_follow_targets_with_a_limited_force(program: CProgram) -> None:
    shoulder, elbow = program.handle("shoulder"), program.handle("elbow")
    program.done("simSetJointTargetVelocity", shoulder, 1.0)
    assert program.done("simGetJointTargetVelocity", shoulder, Out("float *")) == 1.0
    program.done("simSetJointTargetPosition", elbow, -0.4)
    assert program.done("simGetJointTargetPosition", elbow, Out("float *")) == single(-0.4)
    for function in ("simSetJointForce", "simSetJointMaxForce"):
        program.done(function, shoulder, 7.0)
        assert program.done("simGetJointMaxForce", shoulder, Out("float *")) == 7.0
    program.run(1)
    assert program.call("simGetJointForce", shoulder, Out("float *"))[0] == 1
    for _ in range(60):
        program.lib.simExtStep(True)
    assert program.done("simGetJointPosition", elbow, Out("float *")) == pytest.approx(-0.4, abs=0.01)
