"""The tutorial's program, and one with its idioms, pass through simx-run with a stand-in simulator and keyboard.

The program itself is not ours to ship: TUTORIAL_SCRIPT names a copy of it, or it lies beside the repository; else the
scratch program below stands for it. The end-to-end test with a real server is elsewhere.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from launching import python, write_script

pytestmark = pytest.mark.slow

BESIDE = Path(__file__).parents[3] / "shared" / "seed" / "robotControl.py"
TUTORIAL = os.environ.get("TUTORIAL_SCRIPT") or (str(BESIDE) if BESIDE.exists() else "")

PYGAME = """\
from types import SimpleNamespace
import sys
QUIT, KEYDOWN = 1, 2
for _key in 'pqwaszxerdfcvtyl':
    globals()['K_' + _key] = ord(_key)
K_SPACE = 32
_keys = list('qwt y'.replace(' ', '')) + [' ', 'p']
init = lambda: None
display = SimpleNamespace(
    set_mode=lambda size: SimpleNamespace(fill=lambda colour: None, blit=lambda image, place: None),
    set_caption=lambda text: None, update=lambda: None)
key = SimpleNamespace(set_repeat=lambda *a: None, get_pressed=lambda: [])
event = SimpleNamespace(get=lambda: [SimpleNamespace(type=KEYDOWN, key=ord(_keys.pop(0)))])
from . import image
"""
PYGAME_IMAGE = "def load(path):\n    return open(path, 'rb').read()\n"

# Replaces what would need a server, then runs the script as the command line does.
LAUNCH = """
import sys
import simx_client, simx_client.launch.run
from simx_client.calls.images import VisionImage
calls = []
def answer(name, value):
    def function(*arguments):
        calls.append(name)
        return value(*arguments) if callable(value) else value
    setattr(simx_client, name, function)
picture = bytes(range(256)) * (640 * 480 * 3 // 256)
answer('simxStart', 0)
answer('simxFinish', None)
answer('simxStartSimulation', 0)
answer('simxGetObjectHandle', lambda client, name, mode: (0, 10 + len(name)))
answer('simxGetJointPosition', lambda client, handle, mode: (0, 0.25))
answer('simxGetVisionSensorImage', lambda *a: (0, [640, 480], VisionImage.from_bytes(picture, 640, 480)))
answer('simxSetJointTargetPosition', lambda client, handle, angle, mode: float(angle.item()) and 0)
answer('simxCallScriptFunction', (0, [], [], [], bytearray()))
try:
    simx_client.launch.run.main(sys.argv[1:])
finally:
    print(','.join(dict.fromkeys(calls)))
"""

SAME_IDIOMS = r"""
import os
import cv2
import sys
import math
import pygame
import vrep
import numpy as np
class Robot:
    def __init__(self):
        vrep.simxFinish(-1)
        while True:
            clientID = vrep.simxStart('127.0.0.1', 19999, True, True, 5000, 5)
            if clientID > -1:
                break
        vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot)
        self.handle = np.zeros((6, 1), dtype=np.int)
        self.angle = np.zeros((6, 1))
        for i in range(6):
            _, handle = vrep.simxGetObjectHandle(clientID, 'UR5_joint' + str(i+1), vrep.simx_opmode_blocking)
            self.handle[i] = handle
            _, angle = vrep.simxGetJointPosition(clientID, self.handle[i], vrep.simx_opmode_blocking)
            self.angle[i] = angle
        self.clientID = clientID
    def __del__(self):
        vrep.simxFinish(self.clientID)
        print('Simulation end')
    def image(self):
        _, size, image = vrep.simxGetVisionSensorImage(self.clientID, 1, 0, vrep.simx_opmode_blocking)
        channels = []
        for c in (2, 1, 0):
            channel = np.array([image[i] for i in range(c, len(image), 3)])
            channels.append(channel.reshape(480, 640).astype(np.uint8))
        return cv2.flip(cv2.merge(channels), 0)
    def turn(self, number, step):
        target = (self.angle[number] + step) / (180 / math.pi)
        vrep.simxSetJointTargetPosition(self.clientID, self.handle[number], target, vrep.simx_opmode_oneshot)
        self.angle[number] = self.angle[number] + step
    def hand(self, function):
        res, ints, floats, strings, buffer = vrep.simxCallScriptFunction(self.clientID, 'RG2',
            vrep.sim_scripttype_childscript, function, [], [], [], b'', vrep.simx_opmode_blocking)
def main():
    robot = Robot()
    while True:
        path = "imgTemp\\frame.jpg"
        if os.path.exists(path):
            os.remove(path)
        cv2.imwrite(path, robot.image())
        pygame.image.load("imgTemp\\frame.jpg")
        for event in pygame.event.get():
            if event.key == pygame.K_p:
                sys.exit()
            elif event.key == pygame.K_q:
                robot.turn(0, 1)
            elif event.key == pygame.K_w:
                robot.turn(0, -1)
            elif event.key == pygame.K_t:
                robot.hand('rg2Close')
            elif event.key == pygame.K_y:
                robot.hand('rg2Open')
            elif event.key == pygame.K_SPACE:
                cv2.imwrite("saveImg\\rgbImg\\a_rgb.jpg", robot.image())
                cv2.imwrite("saveImg\\depthImg\\a_depth.jpg", robot.image())
if __name__ == '__main__':
    main()
"""

needs_a_copy = pytest.mark.skipif(not TUTORIAL, reason="TUTORIAL_SCRIPT names no copy of the program")


@pytest.mark.parametrize("program", ["same idioms", pytest.param("the original", marks=needs_a_copy)])
def test_tutorial_runs_unchanged_to_its_own_end(tmp_path: Path, program: str) -> None:
    if program == "the original":
        shutil.copy(TUTORIAL, tmp_path / "robotControl.py")
    else:
        write_script(tmp_path, SAME_IDIOMS, "robotControl.py")
    (tmp_path / "pygame").mkdir()
    (tmp_path / "pygame" / "__init__.py").write_text(PYGAME)
    (tmp_path / "pygame" / "image.py").write_text(PYGAME_IMAGE)
    write_script(tmp_path, LAUNCH, "launch.py")
    finished = python(tmp_path, "launch.py", "robotControl.py")
    assert finished.returncode == 0, finished.stderr
    assert finished.stderr == ""
    assert finished.stdout.rstrip().splitlines()[-2:] == [
        "simxFinish,simxStart,simxStartSimulation,simxGetObjectHandle,simxGetJointPosition,"
        "simxGetVisionSensorImage,simxSetJointTargetPosition,simxCallScriptFunction",
        "Simulation end",
    ]
    assert (tmp_path / "imgTemp" / "frame.jpg").stat().st_size > 1000
    assert len(list((tmp_path / "saveImg" / "rgbImg").glob("*_rgb.jpg"))) == 1
    assert len(list((tmp_path / "saveImg" / "depthImg").glob("*_depth.jpg"))) == 1
