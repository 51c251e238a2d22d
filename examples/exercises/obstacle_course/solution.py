"""Drive to (1.8, 1.6) without touching the obstacles."""

import math
import sys

import sim

GOAL = (1.8, 1.6)

ANGLES = [math.radians(angle) for angle in (90, 50, 30, 10, -10, -30, -50, -90)]
"""Directions of the ultrasonic sensors, from the robot's left to its right."""

FAR = 0.7
"""Obstacles that are farther away do not count, m."""

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


def distances():
    """Return the distance of what each of the eight front sensors detects, infinity for nothing."""
    found = [sim.simxReadProximitySensor(client, each, blocking) for each in sonars]
    return [math.hypot(*point) if detects else math.inf for _, detects, point, _, _ in found]


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
    # The goal attracts, each obstacle pushes away and to the side on which the goal is.
    wanted = math.remainder(math.atan2(GOAL[1] - y, GOAL[0] - x) - heading, 2 * math.pi)
    ahead, aside = math.cos(wanted), math.sin(wanted)
    nearest = FAR
    for angle, away in zip(ANGLES, distances(), strict=True):
        if away < FAR:
            push = FAR / max(away, 0.05) - 1
            ahead -= push * math.cos(angle)
            aside -= push * math.sin(angle)
            if abs(angle) < 1:
                nearest = min(nearest, away)
    turn = math.atan2(aside, ahead)
    speed = 4 * min(1, nearest / FAR) * max(0, math.cos(turn))
    sim.simxSetJointTargetVelocity(client, left, speed - 1.5 * turn, oneshot)
    sim.simxSetJointTargetVelocity(client, right, speed + 1.5 * turn, oneshot)
    sim.simxSynchronousTrigger(client)
for motor in (left, right):
    sim.simxSetJointTargetVelocity(client, motor, 0, oneshot)
for _ in range(20):
    sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
