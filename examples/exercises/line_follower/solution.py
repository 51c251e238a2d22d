"""Follow the black line with three light sensors and two wheels."""

import sys

import sim

FAST, SLOW = 5.0, 1.0
"""Velocities of the wheels on the outside and on the inside of a turn, rad/s."""

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


def is_dark(sensor):
    """Return whether a light sensor is over the line."""
    return not sim.simxReadVisionSensor(client, sensor, blocking)[1]


left, right = handle("DynamicLeftJoint"), handle("DynamicRightJoint")
left_eye, right_eye = handle("LeftSensor"), handle("RightSensor")
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
for _ in range(800):
    turn_left, turn_right = is_dark(left_eye), is_dark(right_eye)
    speeds = (SLOW if turn_left else FAST, SLOW if turn_right else FAST)
    sim.simxSetJointTargetVelocity(client, left, speeds[0], oneshot)
    sim.simxSetJointTargetVelocity(client, right, speeds[1], oneshot)
    sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
