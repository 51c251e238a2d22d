"""Move the tip of a planar arm to the ball."""

import sys

import sim

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


joint1, joint2, ball = map(handle, ("joint1", "joint2", "target"))
x, y, _ = sim.simxGetObjectPosition(client, ball, -1, blocking)[1]
print(f"the ball is at {x:.3f}, {y:.3f}")

# Which angles bring the tip there? The first link is 0.5 m long, the second one 0.4 m.
angle1, angle2 = 0.0, 0.0

sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
sim.simxSetJointTargetPosition(client, joint1, angle1, oneshot)
sim.simxSetJointTargetPosition(client, joint2, angle2, oneshot)
for _ in range(150):
    sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
