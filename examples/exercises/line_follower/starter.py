"""Follow the black line with three light sensors and two wheels."""

import sys

import sim

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
left_eye, middle_eye, right_eye = map(handle, ("LeftSensor", "MiddleSensor", "RightSensor"))
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
for _ in range(200):
    # Straight ahead, whatever the sensors see: what should the wheels do instead?
    sim.simxSetJointTargetVelocity(client, left, 4, oneshot)
    sim.simxSetJointTargetVelocity(client, right, 4, oneshot)
    sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
