"""The teaching scenes: what falls is balanced, what reaches reaches; as old scripts do it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from model_checks import load_model, position_of
from real_world import BLOCKING, Open, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = pytest.mark.slow

ONESHOT = vrep.simx_opmode_oneshot


SCENES = {
    "inverted_pendulum": ("pendulum_bob",),
    "cart_pole": ("cart",),
    "two_link_arm": ("link2", "tip"),
}


@pytest.mark.parametrize("scene", SCENES)
def test_model_by_itself_loads_twice(world: Open, scene: str) -> None:
    _, client = world("stock_kinect")
    for place in ((0.0, 2.0), (0.0, 3.0)):
        load_model(client, scene + ".ttm", place)
    for name in SCENES[scene]:
        first, second = (
            position_of(client, handle_of(client, name)),
            position_of(client, handle_of(client, name + "#0")),
        )
        assert second == pytest.approx([first[0], first[1] + 1, first[2]], abs=1e-5)


def push(client: int, joint: int, force: float) -> None:
    """Torque or force as old scripts command it: a velocity it never reaches, and the force as limit."""
    vrep.simxSetJointTargetVelocity(client, joint, math.copysign(1000.0, force), ONESHOT)
    vrep.simxSetJointForce(client, joint, abs(force), ONESHOT)


def motion(client: int, joint: int) -> tuple[float, float]:
    """Position and velocity of a joint."""
    position = vrep.simxGetJointPosition(client, joint, BLOCKING)[1]
    return position, vrep.simxGetObjectFloatParameter(client, joint, 2012, BLOCKING)[1]


def test_inverted_pendulum_is_balanced_by_torques(world: Open) -> None:
    _, client = world("inverted_pendulum")
    vrep.simxSetFloatingParameter(client, vrep.sim_floatparam_simulation_time_step, 0.01, BLOCKING)
    joint = handle_of(client, "pendulum_joint")
    vrep.simxSetJointPosition(client, joint, 0.4, BLOCKING)
    start_stepped(client)
    for _ in range(300):
        angle, rate = motion(client, joint)
        push(client, joint, -30 * angle - 6 * rate)
        step(client, 0.01, 0.01)
    assert abs(motion(client, joint)[0]) < 0.001
    vrep.simxSetJointForce(client, joint, 0.0, ONESHOT)
    vrep.simxSetJointPosition(client, joint, 0.01, ONESHOT)
    step(client, 2.0, 0.01)
    assert abs(motion(client, joint)[0]) > 1  # without torque it falls


def feedback(time_step: float) -> np.ndarray:
    """Gains of cart place, pole angle and their rates: the linear-quadratic regulator of the upright cart-pole."""
    cart, pole, to_centre, gravity = 1.0, 0.1, 0.5, 9.81
    inertia = pole * to_centre**2 * 4 / 3
    mass = np.array([[cart + pole, pole * to_centre], [pole * to_centre, inertia]])
    # State: place, angle, their rates. Leaning makes a torque pole g l angle, the force acts on the cart.
    rates = np.linalg.solve(mass, np.array([[0, 0, 1], [0, pole * gravity * to_centre, 0]]))
    a = np.eye(4) + time_step * np.block([[np.zeros((2, 2)), np.eye(2)], [rates[:, :2], np.zeros((2, 2))]])
    b = time_step * np.array([[0], [0], *rates[:, 2:]])
    cost, effort = np.diag([1.0, 10.0, 0.1, 0.1]), np.array([[0.05]])
    value = cost
    for _ in range(2000):
        gain = np.linalg.solve(effort + b.T @ value @ b, b.T @ value @ a)
        value = cost + a.T @ value @ (a - b @ gain)
    return gain[0]


def test_cart_pole_is_balanced_by_a_linear_regulator(world: Open) -> None:
    _, client = world("cart_pole")
    vrep.simxSetFloatingParameter(client, vrep.sim_floatparam_simulation_time_step, 0.02, BLOCKING)
    slider, pole = handle_of(client, "action"), handle_of(client, "pole_joint")
    vrep.simxSetJointPosition(client, pole, 0.2, BLOCKING)
    start_stepped(client)
    gains = feedback(0.02)
    reached = 0.0
    for _ in range(400):
        (place, speed), (angle, rate) = motion(client, slider), motion(client, pole)
        reached = max(reached, abs(place))
        push(client, slider, -float(gains @ (place, angle, speed, rate)))
        step(client, 0.02, 0.02)
    assert reached < 1.5
    assert abs(motion(client, slider)[0]) < 0.01
    assert abs(motion(client, pole)[0]) < 0.001


@pytest.mark.parametrize("elbow", [1, -1])
def test_two_link_arm_reaches_targets_by_inverse_kinematics(world: Open, elbow: int) -> None:
    _, client = world("two_link_arm")
    shoulder, joint2, tip, target = (
        handle_of(client, name) for name in ("joint1", "joint2", "tip", "target")
    )
    first, second = 0.5, 0.4
    start_stepped(client)
    for goal in (None, (-0.6, 0.3), (0.2, -0.5), (0.0, 0.85)):
        if goal is not None:
            vrep.simxSetObjectPosition(client, target, -1, [*goal, 0.3], BLOCKING)
        x, y, _ = position_of(client, target, handle_of(client, "two_link_arm"))
        bend = elbow * math.acos((x * x + y * y - first**2 - second**2) / (2 * first * second))
        turn = math.atan2(y, x) - math.atan2(second * math.sin(bend), first + second * math.cos(bend))
        vrep.simxSetJointTargetPosition(client, shoulder, math.remainder(turn, 2 * math.pi), ONESHOT)
        vrep.simxSetJointTargetPosition(client, joint2, bend, ONESHOT)
        step(client, 3.0)
        assert math.dist((0, 0, 0), position_of(client, tip, target)) < 0.001
