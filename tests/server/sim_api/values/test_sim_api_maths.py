"""Matrices, poses and angles, as scripts compute with them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

QUARTER = math.pi / 2
TURNED_Z = [0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3]
"""A quarter turn about z, at (1, 2, 3)."""


def near(values: object, tolerance: float = 1e-9) -> object:
    return pytest.approx(values, abs=tolerance)


def test_matrices_are_built_from_angles_and_quaternions(world: ScriptWorld) -> None:
    assert world.value("sim.buildIdentityMatrix()") == [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
    assert world.value("sim.buildMatrix({1,2,3}, {0,0,math.pi/2})") == near(TURNED_Z)
    half = math.sqrt(0.5)
    assert world.value(f"sim.buildMatrixQ({{1,2,3}}, {{0,0,{half},{half}}})") == near(TURNED_Z)
    assert world.value("sim.copyMatrix(sim.buildMatrix({1,2,3}, {0,0,math.pi/2}))") == near(TURNED_Z)


def test_euler_angles_and_quaternions_come_back(world: ScriptWorld) -> None:
    assert world.value("sim.getEulerAnglesFromMatrix(sim.buildMatrix({0,0,0}, {0.3,-0.4,0.5}))") == near(
        [0.3, -0.4, 0.5]
    )
    half = math.sqrt(0.5)
    assert world.value("sim.getQuaternionFromMatrix(sim.buildMatrix({0,0,0}, {math.pi/2,0,0}))") == near(
        [half, 0, 0, half]
    )


def test_poses_and_matrices_say_the_same(world: ScriptWorld) -> None:
    half = math.sqrt(0.5)
    pose = [1, 2, 3, 0, 0, half, half]
    assert world.value("sim.buildPose({1,2,3}, {0,0,math.pi/2})") == near(pose)
    assert world.value(f"sim.buildPose({{1,2,3}}, {{0,0,{half},{half}}})") == near(pose)
    assert world.value("sim.poseToMatrix(sim.buildPose({1,2,3}, {0,0,math.pi/2}))") == near(TURNED_Z)
    assert world.value("sim.matrixToPose(sim.buildMatrix({1,2,3}, {0,0,math.pi/2}))") == near(pose)


def test_poses_are_built_from_axes(world: ScriptWorld) -> None:
    for mode, axis in ((1, 0), (2, 1), (3, 2)):
        matrix = world.value(f"sim.poseToMatrix(sim.buildPose({{0,0,0}}, {{0,2,2}}, {mode}))")
        column = [matrix[axis], matrix[4 + axis], matrix[8 + axis]]
        assert column == near([0, math.sqrt(0.5), math.sqrt(0.5)])
    pairs = {4: (0, 1), 5: (1, 2), 6: (2, 0), 7: (0, 2), 8: (1, 0), 9: (2, 1)}
    for mode, (first, second) in pairs.items():
        matrix = np.array(
            world.value(f"sim.poseToMatrix(sim.buildPose({{0,0,0}}, {{0,0,1}}, {mode}, {{0,3,1}}))")
        )
        rotation = matrix.reshape(3, 4)[:, :3]
        assert rotation[:, first] == near([0, 0, 1])
        assert rotation[:, second] == near([0, 1, 0])
        assert np.linalg.det(rotation) == near(1)
    world.fails("sim.buildPose({0,0,0}, {0,0,1}, 4)", "needs two axes")
    world.fails("sim.buildPose({0,0,0}, {0,0,1}, 10)", "mode of a pose is 0 to 9")


def test_products_and_inverses(world: ScriptWorld) -> None:
    world.lua("a = sim.buildMatrix({1,2,3}, {0.1,0.2,0.3}); b = sim.buildMatrix({-1,0,2}, {-0.5,0.4,1})")
    a, b = (np.vstack([np.array(world.value(name)).reshape(3, 4), [0, 0, 0, 1]]) for name in "ab")
    assert world.value("sim.multiplyMatrices(a, b)") == near((a @ b)[:3].ravel().tolist())
    inverse = np.linalg.inv(a)[:3].ravel().tolist()
    assert world.value("sim.getMatrixInverse(a)") == near(inverse)
    assert world.value(
        "sim.poseToMatrix(sim.multiplyPoses(sim.matrixToPose(a), sim.matrixToPose(b)))"
    ) == near((a @ b)[:3].ravel().tolist())
    assert world.value("sim.poseToMatrix(sim.invertPose(sim.matrixToPose(a)))") == near(inverse)
    assert world.value("sim.poseToMatrix(sim.getPoseInverse(sim.matrixToPose(a)))") == near(inverse)
    assert world.value("sim.getInvertedMatrix(a)") == near(inverse)
    assert world.value("a") == near(a[:3].ravel().tolist()), "nothing so far has changed it"
    assert world.value("sim.invertMatrix(a)") == 1
    assert world.value("a") == near(inverse), "V-REP's scripts look at the table they passed"
    world.lua("simInvertMatrix(a)")
    assert world.value("a") == near(a[:3].ravel().tolist())
    world.fails("sim.invertMatrix(7)", "must be a table, got 7")


def test_vectors_are_moved_one_or_many(world: ScriptWorld) -> None:
    assert world.value("sim.multiplyVector(sim.buildMatrix({1,2,3}, {0,0,math.pi/2}), {1,0,0})") == near(
        [1, 3, 3]
    )
    assert world.value("sim.multiplyVector(sim.buildPose({1,2,3}, {0,0,math.pi/2}), {1,0,0, 0,1,0})") == near(
        [1, 3, 3, 0, 2, 3]
    )
    assert world.value("sim.multiplyVector(sim.buildIdentityMatrix(), {1, 2, 3, 1})") == near([1, 2, 3])
    world.fails("sim.multiplyVector(sim.buildIdentityMatrix(), {1,2})", "a point is 3 numbers, not 2")
    world.fails("sim.multiplyVector({1,2,3}, {1,2,3})", "12 numbers and a pose 7, but this has 3")


def test_between_two_matrices_and_poses(world: ScriptWorld) -> None:
    world.lua("a = sim.buildMatrix({0,0,0}, {0,0,0}); b = sim.buildMatrix({1,2,3}, {0,0,math.pi/2})")
    halfway = world.value("sim.buildMatrix({0.5,1,1.5}, {0,0,math.pi/4})")
    assert world.value("sim.interpolateMatrices(a, b, 0.5)") == near(halfway)
    assert world.value("sim.interpolateMatrices(a, b, 1)") == near(TURNED_Z)
    assert world.value(
        "sim.poseToMatrix(sim.interpolatePoses(sim.matrixToPose(a), sim.matrixToPose(b), 0.5))"
    ) == near(halfway)


def test_rotation_axes(world: ScriptWorld) -> None:
    world.lua("a = sim.buildMatrix({5,0,0}, {0.2,0,0}); b = sim.buildMatrix({0,0,1}, {1.0,0,0})")
    axis, angle = world.lua("return sim.getRotationAxis(a, b)")
    assert axis == near([1, 0, 0])
    assert angle == near(0.8)
    assert world.lua("return sim.getRotationAxis(a, a)")[1] == 0
    turned = world.value("sim.rotateAroundAxis(sim.buildIdentityMatrix(), {0,0,2}, {1,0,0}, math.pi/2)")
    assert turned == near([0, -1, 0, 1, 1, 0, 0, -1, 0, 0, 1, 0])
    half = math.sqrt(0.5)
    assert world.value("sim.rotateAroundAxis({0,0,0,0,0,0,1}, {0,0,2}, {1,0,0}, math.pi/2)") == near(
        [1, -1, 0, 0, 0, half, half]
    )
    world.fails("sim.rotateAroundAxis(a, {0,0,0}, {0,0,0}, 1)", "must not be of length 0")


def test_yaw_pitch_roll_and_alpha_beta_gamma(world: ScriptWorld) -> None:
    angles = world.lua("return sim.yawPitchRollToAlphaBetaGamma(0.3, -0.2, 0.1)")
    back = world.lua(f"return sim.alphaBetaGammaToYawPitchRoll({angles[0]}, {angles[1]}, {angles[2]})")
    assert back == near([0.3, -0.2, 0.1])
    assert world.lua("return sim.alphaBetaGammaToYawPitchRoll(0, 0, 0.7)") == near([0.7, 0, 0])
    assert world.lua("return sim.alphaBetaGammaToYawPitchRoll(0, math.pi/2, 0)")[1] == near(QUARTER)
    assert world.lua("return sim.abgToYpr({0.7, 0, 0})") == [near([0, 0, 0.7])]
    assert world.lua("return sim.yprToAbg({0, 0, 0.7})") == [near([0.7, 0, 0])]


def test_a_table_that_is_no_matrix_is_refused(world: ScriptWorld) -> None:
    world.fails("sim.multiplyMatrices({1,2,3}, sim.buildIdentityMatrix())", "a matrix is 12 finite numbers")
    world.fails("sim.getQuaternionFromMatrix({2,0,0,0, 0,2,0,0, 0,0,2,0})", "holds no rotation")
    world.fails("sim.poseToMatrix({0,0,0,0,0,0,0})", "length 0")
    world.fails("sim.buildMatrix({1,2}, {0,0,0})", "a position is 3 numbers, not 2")
