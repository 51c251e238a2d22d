"""Drive to (1.8, 1.6) without touching the obstacles."""

import math
import sys

import sim

GOAL = (1.8, 1.6)

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


robot = handle("Pioneer_p3dx")
left, right = handle("Pioneer_p3dx_leftMotor"), handle("Pioneer_p3dx_rightMotor")
sonars = [handle(f"Pioneer_p3dx_ultrasonicSensor{number}") for number in range(1, 9)]
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
for _ in range(1000):
    x, y, _ = sim.simxGetObjectPosition(client, robot, -1, blocking)[1]
    heading = sim.simxGetObjectOrientation(client, robot, -1, blocking)[1][2]
    if math.dist((x, y), GOAL) < 0.15:
        break
    # Straight to the goal; the sonars (simxReadProximitySensor) see what is in the way.
    wanted = math.atan2(GOAL[1] - y, GOAL[0] - x)
    turn = math.remainder(wanted - heading, 2 * math.pi)
    sim.simxSetJointTargetVelocity(client, left, 3 - 2 * turn, oneshot)
    sim.simxSetJointTargetVelocity(client, right, 3 + 2 * turn, oneshot)
    sim.simxSynchronousTrigger(client)
for motor in (left, right):
    sim.simxSetJointTargetVelocity(client, motor, 0, oneshot)
for _ in range(20):
    sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
