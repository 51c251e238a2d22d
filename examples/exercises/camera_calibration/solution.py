"""Find the angle and the position of a camera from images of a ball at known places."""

import itertools
import sys

import cv2
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


def middle_of_ball(picture):
    """Return x and y of the ball's middle in pixels; None where it is hidden or cut off."""
    red, green, blue = (picture[..., channel].astype(float) for channel in range(3))
    is_cyan = (red < 0.5 * blue) & (green > 0.6 * blue) & (blue > 80)
    _, _, boxes, middles = cv2.connectedComponentsWithStats(is_cyan.astype(np.uint8))
    largest = 1 + np.argmax(boxes[1:, cv2.CC_STAT_AREA]) if len(boxes) > 1 else 0
    left, low, wide, tall, area = boxes[largest]
    height, width = is_cyan.shape
    is_round = area > 60 and 0.85 < tall / wide < 1.18 and area > 0.7 * tall * wide
    is_whole = 0 < left < width - wide and 0 < low < height - tall
    return middles[largest] + 0.5 if is_round and is_whole else None


def projection(points, seen):
    """Return the 3 x 4 matrix that projects points to image points (direct linear transformation)."""
    scale = np.abs(seen).max()
    rows = []
    for point, (u, v) in zip(points, seen / scale, strict=True):
        x = (*point, 1.0)
        rows.append((*x, 0, 0, 0, 0, *(-u * each for each in x)))
        rows.append((0, 0, 0, 0, *x, *(-v * each for each in x)))
    matrix = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 4)
    return np.diag((scale, scale, 1)) @ matrix


camera, ball = handle("observer"), handle("Target")
sim.simxSynchronous(client, True)
sim.simxStartSimulation(client, blocking)
places, pixels = [], []
for place in itertools.product((-0.75, -0.55, -0.35), (-0.35, -0.1, 0.15), (0.1, 0.3, 0.5)):
    sim.simxSetObjectPosition(client, ball, -1, place, oneshot)
    sim.simxSynchronousTrigger(client)
    found = image()
    seen = middle_of_ball(found)
    if seen is not None:
        places.append(place)
        pixels.append(seen)
height, width = found.shape[:2]
matrix = projection(np.array(places), np.array(pixels) - (width / 2, height / 2))
left = matrix[:, :3] / np.linalg.norm(
    matrix[2, :3]
)  # the rows are f times x, f times y, and the viewing axis
focal = (np.linalg.norm(np.cross(left[0], left[2])) + np.linalg.norm(np.cross(left[1], left[2]))) / 2
position = -np.linalg.solve(matrix[:, :3], matrix[:, 3])
answers = {"view_angle": 2 * np.arctan(width / 2 / focal)}
answers |= {f"camera_{axis}": number for axis, number in zip("xyz", position, strict=True)}

for name, value in answers.items():
    sim.simxSetFloatSignal(client, name, float(value), oneshot)
sim.simxSynchronousTrigger(client)
sim.simxStopSimulation(client, blocking)
sim.simxFinish(client)
