"""Try robot descriptions: ``python tests/urdf/run_robots.py FILE ["FILE NAME:=VALUE ..." ...]``.

FILE is a URDF, a xacro file with the values of its arguments, or an MJCF file of a checkout, which is not changed. Each
robot is loaded as by ``simx-server FILE``, stands for a second, and moves its joints one after the other, its wheels
together. A line of the table has the links, those that are drawn, and their colours; the joints that reached their
target; whether the base is fixed or stands. ``--package`` is that of ``simx-server``. Exit code 1: a robot failed.
"""

from __future__ import annotations

import argparse
import logging
import math
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from simx_server.app.building import build_world
from simx_server.errors import CommandError
from simx_server.joints.state import JointMode
from simx_server.limits import Limits
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf.base import foot_of
from simx_server.scene.objects import ObjectKind
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.world.world import World

ANGLE, LENGTH = 0.15, 0.02
"""How far a joint moves, rad or m; less where its limits are closer."""

NEAR = 0.15
"""Share of the way that may be left."""

SPEED = 2.0
"""rad/s of wheels."""

STANDING, MOVING = 20, 30
"""Simulation steps of 50 ms."""

_SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))

SINKING, RISING = -0.02, 0.05
"""Metres that the lowest point of a free robot may be below or above the floor."""


@dataclass
class Warnings(logging.Handler):
    """Keeps warnings."""

    told: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(logging.WARNING)

    def emit(self, record: logging.LogRecord) -> None:
        self.told.append(record.getMessage())

    __hash__ = object.__hash__


@dataclass
class Result:
    """Numbers about a robot, and its problems."""

    name: str
    seconds: float = 0.0
    links: int = 0
    drawn: int = 0
    colors: int = 0
    joints: int = 0
    reached: int = 0
    still: list[str] = field(default_factory=list)
    base: str = "fixed"
    problem: str = ""
    warnings: list[str] = field(default_factory=list)


def tried(text: str, packages: list[str], images: RenderThread) -> Result:
    """Load a robot and move it."""
    file, *words = text.split()
    arguments = dict(word.split(":=", 1) for word in words)
    result = Result(Path(file).stem.partition(".")[0] + "".join(f" {value}" for value in arguments.values()))
    keeper = Warnings()
    logging.getLogger().addHandler(keeper)
    try:
        began = time.perf_counter()
        world = build_world(images, sources=Sources.of(packages, xacro_arguments=arguments))
        world.simulation.load(Path(file))
        result.seconds = time.perf_counter() - began
        _look_at(world, result)
        _move(world, result)
    except CommandError as error:
        result.problem = str(error)
    finally:
        logging.getLogger().removeHandler(keeper)
    result.warnings = keeper.told
    return result


def _robot(world: World) -> set[int]:
    """Return the bodies of the robot: those with joints, and the others of their trees."""
    model = world.simulation.model
    roots = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in range(model.njnt)}
    return {body for body in range(1, model.nbody) if int(model.body_rootid[body]) in roots}


def _look_at(world: World, result: Result) -> None:
    model, bodies = world.simulation.model, _robot(world)
    seen = [
        geom
        for geom in range(model.ngeom)
        if int(model.geom_bodyid[geom]) in bodies and model.geom_group[geom] < 3
    ]
    result.links = len(bodies)
    result.drawn = len({int(model.geom_bodyid[geom]) for geom in seen})
    colors = {tuple(np.round(model.geom_rgba[geom], 3)) for geom in seen}
    result.colors = len(colors) + len({int(model.geom_matid[geom]) for geom in seen} - {-1})


def _move(world: World, result: Result) -> None:
    """Stand, move joint after joint, then all wheels that did not turn alone, from the start each time."""
    world.simulation.start()
    _step(world, STANDING)
    _check(world)
    result.base = _base(world)
    wheels: list[int] = []
    for item in list(world.simulation.scene.objects.values()):
        if item.kind is not ObjectKind.JOINT or world.simulation.model.jnt_type[item.id] not in _SINGLE:
            continue
        state = world.simulation.joints.state(item.handle)
        if state.mode is JointMode.DEPENDENT or not state.motor:
            continue
        result.joints += 1
        world.simulation.stop()
        world.simulation.start()
        if _reaches(world, item.handle):
            result.reached += 1
        elif state.cyclic:
            wheels.append(item.handle)
        else:
            result.still.append(item.name)
        _check(world)
        _base(world)
    world.simulation.stop()
    world.simulation.start()
    turned = _turn(world, wheels)
    result.reached += len(turned)
    result.still += [world.simulation.scene.get(wheel).name for wheel in wheels if wheel not in turned]
    _check(world)
    _base(world)


def _reaches(world: World, joint: int) -> bool:
    """Return whether a joint moves to a target position."""
    before = world.simulation.joints.position(joint)
    kind = world.simulation.model.jnt_type[world.simulation.scene.get(joint).id]
    way = LENGTH if kind == mujoco.mjtJoint.mjJNT_SLIDE else ANGLE
    _, low, width = world.simulation.joints.interval(joint)
    high = low + width
    target = min(before + way, high) if high - before > before - low else max(before - way, low)
    world.simulation.joints.set_target_position(joint, target)
    _step(world, MOVING)
    left = abs(_turned(target, world.simulation.joints.position(joint)))
    return left <= NEAR * abs(target - before) + 1e-4


def _turn(world: World, wheels: list[int]) -> list[int]:
    """Turn wheels at the same time; return those that keep their velocity."""
    for wheel in wheels:
        world.simulation.joints.set_target_velocity(wheel, SPEED)
    before = [world.simulation.joints.position(wheel) for wheel in wheels]
    _step(world, MOVING)
    wanted = SPEED * MOVING * world.simulation.time_step
    return [
        wheel
        for wheel, start in zip(wheels, before, strict=True)
        if abs(_turned(start + wanted, world.simulation.joints.position(wheel))) < 2 * NEAR * wanted
    ]


def _turned(before: float, after: float) -> float:
    return (after - before + math.pi) % (2 * math.pi) - math.pi


def _step(world: World, count: int) -> None:
    for _ in range(count):
        world.step()


def _check(world: World) -> None:
    if not (np.isfinite(world.simulation.data.qpos).all() and np.isfinite(world.simulation.data.qvel).all()):
        raise CommandError("a position is not finite")
    if np.abs(world.simulation.data.qvel).max(initial=0.0) > 200.0:
        raise CommandError(f"a velocity is {np.abs(world.simulation.data.qvel).max():.0f}")


def _base(world: World) -> str:
    """Return how a free robot stands."""
    model, data = world.simulation.model, world.simulation.data
    free = [joint for joint in range(model.njnt) if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE]
    if not free:
        return "fixed"
    body = int(model.jnt_bodyid[free[0]])
    up = float(data.xmat[body].reshape(3, 3)[2, 2])
    lowest, name = min(
        (foot_of(model, data, geom).lowest, model.body(int(model.geom_bodyid[geom])).name)
        for geom in range(model.ngeom)
        if int(model.body_rootid[model.geom_bodyid[geom]]) == body and model.geom_contype[geom]
    )
    if not SINKING < lowest < RISING:
        raise CommandError(
            f"the lowest point of the free robot, of {name}, is {lowest:.3f} m above the floor"
        )
    return f"free, {'upright' if up > 0.9 else f'tilted by {math.degrees(math.acos(up)):.0f} degrees'}"


def main() -> int:
    """Print the table; return 1 if a robot failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("robots", metavar="ROBOT", nargs="+")
    parser.add_argument("--package", metavar="NAME=DIR", action="append", default=[])
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="print warnings, and joints that did not move"
    )
    options = parser.parse_args()
    images = RenderThread(limits=Limits())
    failed = 0
    print("| robot | links | drawn | colours | moved / joints | base | s |\n|---|---|---|---|---|---|---|")
    for text in options.robots:
        result = tried(text, options.package, images)
        failed += bool(result.problem)
        numbers = f"{result.links} | {result.drawn} | {result.colors} | {result.reached} / {result.joints}"
        print(
            f"| {result.name} | {numbers} | {result.problem or result.base} | {result.seconds:.1f} |",
            flush=True,
        )
        if options.verbose:
            for line in [*result.warnings, *(f"not moved: {name}" for name in result.still)]:
                print(f"    {line}", flush=True)
    images.close()
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
