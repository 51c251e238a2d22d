"""Pick the cube and put it on the mark."""

import math
import sys

import sim

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


target, tip, cube, mark = map(handle, ("UR5_target", "UR5_tip", "Cube", "Mark"))
joints = [handle(f"UR5_joint{number}") for number in range(1, 7)]
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)

# Bend the arm until the gripper points down; straight up it cannot follow its target.
for joint, angle in zip(joints, (110, 15, 65, 10, -90, 20), strict=True):
    sim.simxSetJointTargetPosition(client, joint, math.radians(angle), oneshot)
sim.simxSetIntegerSignal(client, "RG2_open", 1, oneshot)
for _ in range(60):
    sim.simxSynchronousTrigger(client)

# Now move UR5_target (simxSetObjectPosition) a little in each step: the gripper follows it.
# RG2_open = 0 closes the gripper.

sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
