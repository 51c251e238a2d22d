"""Move the tip of a planar arm to the ball."""

import math
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

cosine = (x * x + y * y - 0.5**2 - 0.4**2) / (2 * 0.5 * 0.4)
angle2 = math.acos(max(-1.0, min(1.0, cosine)))
angle1 = math.atan2(y, x) - math.atan2(0.4 * math.sin(angle2), 0.5 + 0.4 * math.cos(angle2))

sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
sim.simxSetJointTargetPosition(client, joint1, angle1, oneshot)
sim.simxSetJointTargetPosition(client, joint2, angle2, oneshot)
for _ in range(150):
    sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
