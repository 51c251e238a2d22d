"""Drive the tutorial's robot with the keyboard and look through the camera on its hand.

    simx-run --server ur5_rg2_kinect examples/keyboard_control.py

With a display a window follows the keys. Without one, or with --scripted, the program presses its own
keys: it goes to a good view, moves every joint, closes and opens the gripper, takes pictures, tells what it
saw, and ends.
It is written as a script for V-REP would be: it knows `vrep` and nothing else of the simulator.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import vrep

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame
except ModuleNotFoundError:
    from simx_client.protocol.cli.installing import extra_line

    sys.exit(f"the package pygame is not installed, which opens the window: {extra_line('demo')}")

WAIT = vrep.simx_opmode_blocking
SEND = vrep.simx_opmode_oneshot

VIEW_POSE = [90.0, -45.0, 90.0, 0.0, -100.0, 0.0]
"""Joint angles in degrees at which the hand camera sees the ball."""

JOINT_KEYS = ["qw", "as", "zx", "er", "df", "cv"]
"""For each joint the key that turns it forwards and the one that turns it back."""

TURNS = {
    getattr(pygame, f"K_{key}"): (joint, sign)
    for joint, pair in enumerate(JOINT_KEYS)
    for key, sign in zip(pair, (+1, -1), strict=True)
}

CAPTION = "joints q/w a/s z/x e/r d/f c/v   gripper t/y   g view   l reset   space save   p quit"
BLACK = "Black is right here: the arm points up and its camera looks over the floor. Press g for a view."

CLOSED, OPEN = -0.045, 0.05
"""Positions of RG2_openCloseJoint in metres beyond which the empty gripper counts as closed, as open."""


def say(text: str) -> None:
    print(text, flush=True)


class Robot:
    """A UR5 with an RG2 gripper and two cameras on its hand, as one legacy client sees them."""

    def __init__(self, address: str, port: int, seconds: float = 15.0) -> None:
        vrep.simxFinish(-1)
        deadline = time.monotonic() + seconds
        while (client := vrep.simxStart(address, port, True, True, 5000, 5)) == -1:
            if time.monotonic() > deadline:
                sys.exit(f"no simulator answers at {address}:{port}; start one with: simx-server")
        self.client = client
        vrep.simxStartSimulation(client, WAIT)
        self.joints = [self._handle(f"UR5_joint{number}") for number in range(1, 7)]
        self.fingers = self._handle("RG2_openCloseJoint")
        self.rgb, self.depth = self._handle("kinect_rgb"), self._handle("kinect_depth")
        self.target = [math.degrees(angle) for angle in self.angles()]
        vrep.simxGetVisionSensorImage(client, self.rgb, 0, vrep.simx_opmode_streaming)

    def _handle(self, name: str) -> int:
        code, handle = vrep.simxGetObjectHandle(self.client, name, WAIT)
        if code != vrep.simx_return_ok:
            sys.exit(f"the scene has no {name}; this program needs the tutorial's scene, ur5_rg2_kinect")
        return handle

    def _position(self, joint: int) -> float:
        code, value = vrep.simxGetJointPosition(self.client, joint, WAIT)
        if code != vrep.simx_return_ok:
            sys.exit(f"the simulator is gone (return code {code})")
        return value

    def angles(self) -> list[float]:
        """Measured joint angles in radians."""
        return [self._position(joint) for joint in self.joints]

    def go(self, degrees: list[float]) -> None:
        """New targets for all joints, in one message so that they set off together."""
        self.target = list(degrees)
        vrep.simxPauseCommunication(self.client, True)
        for joint, angle in zip(self.joints, degrees, strict=True):
            vrep.simxSetJointTargetPosition(self.client, joint, math.radians(angle), SEND)
        vrep.simxPauseCommunication(self.client, False)

    def turn(self, joint: int, degrees: float) -> None:
        """Move one joint's target, counted from 0, by so many degrees."""
        self.target[joint] += degrees
        goal = math.radians(self.target[joint])
        vrep.simxSetJointTargetPosition(self.client, self.joints[joint], goal, SEND)

    def has_arrived(self) -> bool:
        """Every joint is within half a degree of its target."""
        pairs = zip(self.angles(), self.target, strict=True)
        return all(abs(math.degrees(angle) - target) < 0.5 for angle, target in pairs)

    def grip(self, function: str) -> None:
        """Call a function of the gripper's own script: rg2Close or rg2Open."""
        kind = vrep.sim_scripttype_childscript
        code, *_ = vrep.simxCallScriptFunction(
            self.client, "RG2", kind, function, [], [], [], bytearray(), WAIT
        )
        if code != vrep.simx_return_ok:
            say(f"the gripper's script did not run {function} (return code {code})")

    def gap(self) -> float:
        """Position of the gripper's joint in metres, more is more open."""
        return self._position(self.fingers)

    def picture(self, sensor: int, mode: int) -> np.ndarray | None:
        """(height, width, 3) uint8, RGB, top row first; None while there is none."""
        code, resolution, image = vrep.simxGetVisionSensorImage(self.client, sensor, 0, mode)
        if code != vrep.simx_return_ok:
            return None
        width, height = resolution
        return np.flipud(np.array(image, dtype=np.uint8).reshape(height, width, 3))

    def distances(self) -> np.ndarray | None:
        """(height, width) float, top row first: metres along the viewing direction."""
        code, resolution, buffer = vrep.simxGetVisionSensorDepthBuffer(self.client, self.depth, WAIT)
        near = self._clip_plane(vrep.sim_visionfloatparam_near_clipping)
        far = self._clip_plane(vrep.sim_visionfloatparam_far_clipping)
        if code != vrep.simx_return_ok or near is None or far is None:
            return None
        width, height = resolution
        return near + (far - near) * np.flipud(np.array(buffer, dtype=float).reshape(height, width))

    def _clip_plane(self, parameter: int) -> float | None:
        code, metres = vrep.simxGetObjectFloatParameter(self.client, self.depth, parameter, WAIT)
        return metres if code == vrep.simx_return_ok else None


class Ball(NamedTuple):
    """The cyan ball in a picture."""

    u: int
    v: int
    pixels: int
    colour: tuple[int, int, int]


def find_ball(rgb: np.ndarray) -> Ball | None:
    """The largest patch of saturated cyan: its centre (u right, v down), size and mean RGB colour."""
    hsv = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2HSV)
    mask = cv2.inRange(hsv, (85, 150, 60), (105, 255, 255))
    count, labels, stats, centres = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        return None
    best = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    red, green, blue = (round(float(value)) for value in rgb[labels == best].mean(axis=0))
    u, v = (round(float(value)) for value in centres[best])
    return Ball(u, v, int(stats[best, cv2.CC_STAT_AREA]), (red, green, blue))


class Album:
    """The folder that pictures are saved to, numbered from 001."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.saved = 0

    def save(self, robot: Robot) -> None:
        """Colour and depth pictures to files, and a sentence about the ball."""
        colours, greys = robot.picture(robot.rgb, WAIT), robot.picture(robot.depth, WAIT)
        if colours is None or greys is None:
            say("the cameras give no picture; the simulator's log tells why")
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        taken = len(list(self.folder.glob("rgb_*.png")))
        # OpenCV wants blue first; near is dark in the raw depth picture, so it is turned round for the eye.
        pictures = {
            "rgb": cv2.cvtColor(np.ascontiguousarray(colours), cv2.COLOR_RGB2BGR),
            "depth": 255 - greys,
        }
        for name, pixels in pictures.items():
            path = self.folder / f"{name}_{taken + 1:03}.png"
            if not cv2.imwrite(str(path), pixels):
                sys.exit(f"cannot write {path}")
            say(f"saved {path}")
        self.saved += 1
        self._tell(find_ball(colours), robot.distances())

    def _tell(self, ball: Ball | None, distances: np.ndarray | None) -> None:
        if ball is None:
            say("no ball in this picture; press g for a view that has one")
            return
        where = f"the ball fills {ball.pixels} pixels around ({ball.u}, {ball.v}), mean colour {ball.colour}"
        if distances is not None:
            where += f", {distances[ball.v, ball.u]:.2f} m in front of the camera"
        say(where)


class Cockpit:
    """The window, and what each key does."""

    def __init__(self, robot: Robot, album: Album, step: float) -> None:
        self.robot, self.album, self.step = robot, album, step
        self.is_open = True
        pygame.display.init()
        pygame.font.init()
        pygame.key.set_repeat(200, 50)
        self.screen = pygame.display.set_mode((640, 480))
        pygame.display.set_caption(CAPTION)
        self.font = pygame.font.Font(None, 20)
        self.actions: dict[int, Callable[[], Any]] = {
            pygame.K_t: lambda: robot.grip("rg2Close"),
            pygame.K_y: lambda: robot.grip("rg2Open"),
            pygame.K_g: lambda: robot.go(VIEW_POSE),
            pygame.K_l: lambda: robot.go([0.0] * 6),
            pygame.K_SPACE: lambda: album.save(robot),
            pygame.K_p: self.close,
        }

    def close(self) -> None:
        self.is_open = False

    def obey(self, event: pygame.event.Event) -> None:
        """Do what a key or the window's cross asks for."""
        if event.type == pygame.QUIT:
            self.close()
        elif event.type == pygame.KEYDOWN and event.key in TURNS:
            joint, sign = TURNS[event.key]
            self.robot.turn(joint, sign * self.step)
        elif event.type == pygame.KEYDOWN and event.key in self.actions:
            self.actions[event.key]()
        elif event.type == pygame.KEYDOWN:
            say(f"{pygame.key.name(event.key)} has no meaning here: {CAPTION}")

    def show(self) -> None:
        """The newest picture of the hand camera that has arrived."""
        pixels = self.robot.picture(self.robot.rgb, vrep.simx_opmode_buffer)
        if pixels is None:
            return
        surface = pygame.surfarray.make_surface(pixels.swapaxes(0, 1))
        if surface.get_size() != self.screen.get_size():
            self.screen = pygame.display.set_mode(surface.get_size())
        self.screen.blit(surface, (0, 0))
        if not pixels.any():
            self.screen.blit(self.font.render(BLACK, True, (200, 200, 200)), (12, 12))
        pygame.display.flip()

    def run(self, fingers: Iterator[None] | None = None) -> None:
        """Until somebody quits; `fingers` press keys, one frame at each of their turns."""
        clock = pygame.time.Clock()
        while self.is_open:
            if fingers is not None:
                next(fingers, None)
            for event in pygame.event.get():
                self.obey(event)
            self.show()
            clock.tick(30)
        pygame.quit()


def scripted_keys(robot: Robot, album: Album) -> Iterator[None]:
    """Press keys as a person would, one a frame, and wait where a person would watch."""

    def press(key: str) -> None:
        code = pygame.key.key_code(key)
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=code, mod=0, unicode=key))
        pygame.event.post(pygame.event.Event(pygame.KEYUP, key=code, mod=0))

    def until(what: str, condition: Callable[[], bool], seconds: float = 30.0) -> Iterator[None]:
        deadline = time.monotonic() + seconds
        yield
        while not condition():
            if time.monotonic() > deadline:
                sys.exit(f"gave up: {what} did not happen within {seconds:.0f} s")
            yield

    press("g")
    yield from until("arriving at the view pose", robot.has_arrived)
    say("[1/5] g: the arm is at the view pose")
    for forwards, back in JOINT_KEYS:
        for key in forwards * 8 + back * 8:
            press(key)
            yield
    yield from until("coming back to the view pose", robot.has_arrived)
    say("[2/5] " + " ".join(JOINT_KEYS) + ": every joint has turned a little, and back")
    press("t")
    yield from until("closing the gripper", lambda: robot.gap() < CLOSED)
    say(f"[3/5] t: the gripper is closed, its joint is at {robot.gap():+.3f} m")
    press("y")
    yield from until("opening the gripper", lambda: robot.gap() > OPEN)
    say(f"[4/5] y: the gripper is open, its joint is at {robot.gap():+.3f} m")
    press("space")
    yield from until("saving a picture", lambda: album.saved > 0)
    say("[5/5] space: a colour and a depth image are saved")
    press("p")


def has_display() -> bool:
    """Only X and Wayland systems can lack one without anybody noticing."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def main() -> None:
    parser = argparse.ArgumentParser(description="Keyboard control of the tutorial's robot.")
    parser.add_argument("--scripted", action="store_true", help="press the keys itself, without a window")
    parser.add_argument("--output", type=Path, default=Path("demo_output"), help="folder for pictures")
    parser.add_argument("--address", default="127.0.0.1", help="where the simulator is")
    parser.add_argument("--port", type=int, default=19999, help="the simulator's port")
    parser.add_argument("--step", type=float, default=1.0, help="degrees per key press")
    chosen = parser.parse_args()
    scripted = chosen.scripted or not has_display()
    if scripted:
        os.environ["SDL_VIDEODRIVER"] = "dummy"

    robot, album = Robot(chosen.address, chosen.port), Album(chosen.output)
    say("connected; " + ("the program presses its own keys" if scripted else CAPTION))
    try:
        cockpit = Cockpit(robot, album, chosen.step)
        cockpit.run(scripted_keys(robot, album) if scripted else None)
    finally:
        vrep.simxFinish(robot.client)
    say(f"done; pictures are in {album.folder.resolve()}" if album.saved else "done")


if __name__ == "__main__":
    main()
