"""Pick the cube and put it on the mark."""

import math
import sys

import sim

STEP = 0.008
"""Way of the target within a simulation step, m."""

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


def position(object):
    return sim.simxGetObjectPosition(client, object, -1, blocking)[1]


def wait(steps):
    for _ in range(steps):
        sim.simxSynchronousTrigger(client)


def move(goal):
    """Move the target to a place in a straight line, then let the arm arrive."""
    start = position(target)
    steps = max(1, math.ceil(math.dist(start, goal) / STEP))
    for step in range(1, steps + 1):
        place = [a + (b - a) * step / steps for a, b in zip(start, goal, strict=True)]
        sim.simxSetObjectPosition(client, target, -1, place, oneshot)
        wait(1)
    wait(15)


def set_gripper(is_open):
    sim.simxSetIntegerSignal(client, "RG2_open", int(is_open), oneshot)
    wait(25)


target, tip, cube, mark = map(handle, ("UR5_target", "UR5_tip", "Cube", "Mark"))
joints = [handle(f"UR5_joint{number}") for number in range(1, 7)]
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
for joint, angle in zip(joints, (110, 15, 65, 10, -90, 20), strict=True):
    sim.simxSetJointTargetPosition(client, joint, math.radians(angle), oneshot)
sim.simxSetIntegerSignal(client, "RG2_open", 1, oneshot)
wait(60)
sim.simxSetObjectPosition(client, target, tip, (0, 0, 0), oneshot)
sim.simxSetObjectQuaternion(client, target, tip, (0, 0, 0, 1), oneshot)

x, y, z = position(cube)
move((x, y, 0.15))
move((x, y, z))
set_gripper(False)
move((x, y, 0.2))
x, y, _ = position(mark)
move((x, y, 0.2))
move((x, y, 0.032))
set_gripper(True)
move((x, y, 0.2))
wait(20)

sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
