"""``python -m bench.motion [--samples FOLDER] [--stock FOLDER]``: run all robots, write `docs/internals/motion.md`."""

from __future__ import annotations

import argparse
import logging
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from bench.motion.arms import arm
from bench.motion.balance import ASIDE, FOLLOW, SPEED, STAND, balance
from bench.motion.cars import CARS, drive
from bench.motion.drives import Differential, differential, mecanum
from bench.motion.holding.grasps import Hand, trial
from bench.motion.holding.hands import SHIPPED, STOCK
from bench.motion.holding.held_objects import KINDS
from bench.motion.hover import hover
from bench.motion.lines import follow
from bench.motion.opened import running
from bench.motion.rest import jitter
from bench.motion.samples import samples
from bench.motion.tower import build_tower
from bench.motion.walkers import BASES, rest, walk
from simx_server.files.library import list_scenes

ROOT = Path(__file__).parents[2]
PAGE, SCENES = ROOT / "docs" / "internals" / "motion.md", ROOT / "scenes"

DRIVES = {
    "Pioneer P3-DX": Differential("pioneer_p3dx", "Pioneer_p3dx_leftMotor", "Pioneer_p3dx_rightMotor"),
    "BubbleRob": Differential("bubblerob", "bubbleRob_leftMotor", "bubbleRob_rightMotor"),
    "e-puck": Differential("e_puck", "ePuck_leftJoint", "ePuck_rightJoint"),
    "LineTracer": Differential("line_follower", "DynamicLeftJoint", "DynamicRightJoint"),
    "K-Junior": Differential("k_junior", "KJunior_motorLeft", "KJunior_motorRight"),
    "Khepera III": Differential("khepera_iii", "K3_leftWheelMotor", "K3_rightWheelMotor"),
    "lumibot": Differential("lumibot", "lumibot_leftMotor", "lumibot_rightMotor"),
    "dr12": Differential("dr12", "dr12_leftJoint_", "dr12_rightJoint_"),
}

ARMS = {
    "UR3": "ur3",
    "UR5": "ur5",
    "UR10": "ur10",
    "Franka Emika Panda": "frankaemikapanda",
    "KUKA LBR iiwa 7": "kuka_lbr_iiwa_7_r800",
    "KUKA LBR iiwa 14": "kuka_lbr_iiwa_14_r820",
    "KUKA LBR4+": "kuka_lbr4",
    "Jaco": "jaco_arm",
    "Mico": "mico_arm",
    "ABB IRB 140": "abb_irb_140",
    "two_link_arm": "two_link_arm",
}

INTRODUCTION = """# How robots move

This page shows what the shipped robots and V-REP's own files do, beside what they should do.
`python -m bench.motion --samples FOLDER --stock FOLDER` writes it. Physics is deterministic, so the numbers belong to
the code and not to the machine, except the last column of each table: the processor time of a
simulation step as a part of the time that it simulates.

A motor keeps the commanded velocity with at most its maximum force, as in V-REP's physics engines: it is
a constraint that MuJoCo solves together with the contacts. All these robots have simulation steps of
50 ms and physics steps of 5 ms, as in V-REP, unless a table says otherwise.
"""


MASSES = (0.02, 0.2, 1.0)
"""kg, of what grippers take."""


def page(sampled: Path | None, stock: Path | None) -> str:
    """Return the page.

    Args:
        sampled: folder with scenes of V-REP; None: their table is left out.
        stock: V-REP's folder `models`; None: rows of its models are left out.
    """
    parts = [INTRODUCTION, *_wheels(), *_cars(stock), *_arms(), *_others(stock), *_grasps(stock)]
    if stock is not None:
        parts += _walkers(stock)
    parts += _rest()
    if sampled is not None:
        parts += _samples(sampled)
    return "\n".join(parts) + "\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table; a column with the same value in all rows becomes a line below it."""
    columns = dict(zip(head, zip(*rows, strict=True), strict=True))
    same = {name: values[0] for name, values in columns.items() if len(set(values)) == 1 < len(rows)}
    shown = [number for number, name in enumerate(head) if name not in same]
    lines = [f"| {' | '.join(line[number] for number in shown)} |" for line in (head, *rows)]
    lines.insert(1, "|---|" + "---:|" * (len(shown) - 1))
    if same:
        lines += ["", f"In all rows: {', '.join(f'{name} {value}' for name, value in same.items())}."]
    return "\n".join(lines) + "\n"


def _wheels() -> list[str]:
    rows: list[list[str]] = []
    for name, robot in DRIVES.items():
        found = differential(robot)
        rows.append(
            [
                name,
                f"{found.speed:.4f}",
                f"{1000 * found.side:.1f} mm",
                f"{math.degrees(found.yaw):.3f}°",
                f"{found.turning:.4f}",
                f"{100 * found.wheels:.3f} %",
                f"{100 * found.share:.1f} %",
            ]
        )
    base = mecanum()
    return [
        "## Wheels\n",
        "A straight drive of 30 s at 0.1 m/s, then turns. Speeds are parts of what wheel velocities, radius and\n"
        "track give: 1 is right. The row shows the turn that is farthest from 1.\n",
        _table(
            (
                "robot",
                "speed",
                "beside its line",
                "turned",
                "yaw rate",
                "wheel beside its command",
                "of real time",
            ),
            rows,
        ),
        "The youBot drives ahead, sideways, about itself and combined, each within "
        f"{100 * base.error:.1f} % of the kinematics. Its velocity changes by at most "
        f"{1e3 * base.jump:.3f} mm/s from one simulation step to the next.\n",
    ]


def _cars(stock: Path | None) -> list[str]:
    rows: list[list[str]] = []
    for name, car in CARS.items():
        files = {"shipped": SCENES / "models" / f"{name.replace(' ', '_').lower()}.xml"}
        if stock is not None:
            files["V-REP's"] = next(stock.rglob(f"{name}.ttm"))
        for source, file in files.items():
            found = drive(file, car)
            rows.append(
                [
                    f"{name}, {source}",
                    f"{found.speed:.4f}",
                    f"{1000 * found.side:.2f} mm",
                    f"{math.degrees(found.yaw):.3f}°",
                    f"{found.radius:.3f} m",
                    f"{found.geometry:.3f} m",
                    f"{100 * found.share:.1f} %",
                ]
            )
    return [
        "Cars with steered front wheels stand on an endless floor, drive straight for 20 s, and turn to the left\n"
        "for 10 s with the front wheels at 0.4 rad. The radius is that of the middle of the rear axle, beside the\n"
        "point where the axes of the front wheels meet that of the rear ones. Speeds are 0.5 to 1 m/s.\n",
        _table(
            (
                "car",
                "speed",
                "beside its line, per m",
                "turned",
                "radius",
                "by the wheels' axes",
                "of real time",
            ),
            rows,
        ),
    ]


def _arms() -> list[str]:
    rows: list[list[str]] = []
    for name, model in ARMS.items():
        found = arm(model)
        rows.append(
            [
                name,
                str(found.joints),
                f"{1e6 * found.lag:.1f} µrad",
                f"{100 * found.force:.2f} %",
                f"{100 * found.peak:.0f} %",
                f"{100 * found.overshoot:.1f} %",
                f"{100 * found.share:.1f} %",
            ]
        )
    return [
        "## Arms\n",
        "All joints under position control move together. The lag behind the targets is compared with V-REP's\n"
        "law: a position controller removes the part P of its error in each 5 ms. The reported force is compared\n"
        "with the inverse dynamics of the motion.\n",
        _table(
            (
                "arm",
                "joints",
                "lag beside the law",
                "force beside the inverse dynamics",
                "greatest force, of the maximum",
                "overshoot of one degree",
                "of real time",
            ),
            rows,
        ),
    ]


def _others(stock: Path | None) -> list[str]:
    flight, line = hover(), follow()
    return [
        "## Flying, following a line, balancing, stacking\n",
        _table(
            ("robot", "what it does", "found", "of real time"),
            [
                [
                    "Quadricopter",
                    "hovers 10 s, flies 0.5 m aside",
                    f"sinks {1000 * flight.dip:.2f} mm; rests {1000 * flight.error:.3f} mm and "
                    f"{1000 * flight.arrival:.3f} mm from its targets",
                    f"{100 * flight.share:.1f} %",
                ],
                [
                    "LineTracer",
                    "follows its track for 30 s by its three eyes",
                    f"at most {1000 * line.farthest:.0f} mm from the line, {math.degrees(line.way):.0f}° of the round",
                    f"{100 * line.share:.1f} %",
                ],
                *([_ball_robot(stock), _tower(stock)] if stock is not None else []),
            ],
        ),
    ]


def _ball_robot(stock: Path) -> list[str]:
    found = balance(next(stock.rglob("ball robot.ttm")))
    return [
        "ball robot, V-REP's",
        f"balances {STAND:g} s on its ball, follows its target for {ASIDE:g} m at {SPEED:g} m/s, {FOLLOW:g} s in all",
        f"tilts by {math.degrees(found.standing):.2f}° and {math.degrees(found.tilt):.2f}°; rests "
        f"{1000 * found.error:.2f} mm from its target",
        f"{100 * found.share:.1f} %",
    ]


def _tower(stock: Path) -> list[str]:
    found = build_tower(stock.parent / "scenes" / "ur5WithRg2Grasping.ttt")
    return [
        "ur5WithRg2Grasping, V-REP's",
        "takes six cuboids from a belt, lays two by two crosswise on one another",
        f"{', '.join(map(str, found.layers))} in its layers, tilted by at most {math.degrees(found.tilt):.2f}°; "
        f"its script ends it after {found.seconds:.1f} s",
        f"{100 * found.share:.1f} %",
    ]


def _grasps(stock: Path | None) -> list[str]:
    rows = _hands("shipped", SCENES / "models", SHIPPED)
    if stock is not None:
        rows += _hands("V-REP's", stock / "components" / "grippers", STOCK)
    return [
        "## Grasps\n",
        "Each gripper takes a box, a cylinder, a cup and a mesh of 20 g, 200 g and 1 kg, lifts them, turns them\n"
        "upside down, carries them to and fro at 0.5 m/s, and holds them for 30 s, at simulation steps of 50 ms and\n"
        "the default force. The movement is that in the hand, of the objects that were not lost: while they were\n"
        "carried, and in the 30 s. The force is the greatest mean of a motor, with its standard deviation.\n\n"
        "In brackets: the friction that the closed fingers can give, as a part of the object's weight. Holding it\n"
        "against gravity alone needs 1, to turn and swing it needs more: motors of 10 N cannot hold 1 kg.\n"
        "Fingers of the simplified Barrett hand have two free joints each, and yield before their tips slip.\n"
        "[grasps.md](../grasps.md) has PyRep's grippers, and what to tune.\n",
        _table(("gripper", "held, of 12", "lost", "while carried", "in 30 s", "force"), rows),
    ]


def _hands(source: str, folder: Path, hands: Mapping[str, Hand]) -> list[list[str]]:
    rows: list[list[str]] = []
    for file, hand in hands.items():
        found = {
            f"{kind} of {1000 * mass:g} g": trial(folder / file, hand, kind, mass)
            for kind in KINDS
            for mass in MASSES
        }
        held = [one for one in found.values() if not one.lost]
        force, spread = max((abs(mean), spread) for one in held for mean, spread in one.force.values())
        rows.append(
            [
                f"`{file}`, {source}",
                str(len(held)),
                ", ".join(f"{name} ({one.hold:.1f})" for name, one in found.items() if one.lost) or "none",
                f"{max(one.shift for one in held):.2f} mm",
                f"{max(one.creep for one in held):.3f} mm",
                f"{force:.2f}, {spread:.3f}",
            ]
        )
    return rows


def _walkers(stock: Path) -> list[str]:
    rows: list[list[str]] = []
    for name in BASES:
        file = next(stock.rglob(f"{name}.ttm"))
        found = walk(file)
        rows.append(
            [
                name,
                f"{found.distance:.2f} m",
                f"{found.way:.2f} m",
                f"{found.lowest:.3f} to {found.highest:.3f} m",
                f"{math.degrees(found.tilt):.1f}°",
                f"{1000 * rest(file):.2g} mm/s",
                str(found.stopped),
                f"{100 * found.share:.1f} %",
            ]
        )
    return [
        "## Walking and slithering\n",
        "V-REP's own models on its default floor, for 30 s under their scripts: how far the base is from its\n"
        "start, the length of its way, its height, its greatest tilt, and the fastest part while no script runs.\n"
        "Snake rolls, NAO only stands, and the hexapods stay on the spot first, as their scripts want.\n",
        _table(
            (
                "robot",
                "distance",
                "way",
                "height",
                "tilt",
                "fastest part at rest",
                "scripts stopped",
                "of real time",
            ),
            rows,
        ),
    ]


REST = 1e-5
"""Speed in m/s below which nothing moves for the page."""
SLOW = 0.1
"""Part of real time above which a file has its row."""


def _rest() -> list[str]:
    moving: list[str] = []
    resting: list[str] = []
    for scene in list_scenes():
        with running(scene) as one:
            fastest = jitter(one)
            if fastest < REST:
                resting.append(scene)
            else:
                moving.append(f"`{scene}` {1000 * fastest:.2g} mm/s")
    return [
        "## At rest\n",
        "The fastest part of each shipped scene, 4 to 6 s after the start, while no program commands anything:\n"
        f"{', '.join(moving)}. Slower than {1000 * REST:g} mm/s:\n{_names(resting)}.\n",
    ]


def _samples(folder: Path) -> list[str]:
    rows: list[list[str]] = []
    resting: list[str] = []
    for found in samples(folder):
        if found.ran and found.fastest < REST and not found.stopped and found.share < SLOW:
            resting.append(found.name)
            continue
        rows.append(
            [
                found.name,
                f"{1000 * found.fastest:.2g} mm/s",
                str(found.stopped),
                "yes" if found.ran else "no",
                f"{100 * found.share:.1f} %",
            ]
        )
    return [
        "## Files of V-REP\n",
        "Public files run for 30 s with their scripts. The fastest part of the last two seconds is 0 or tiny where\n"
        "nothing drives; `Mobile_robots`, `MyAckermannSteeringModel`, `MyDifferentialDriveModel` and\n"
        "`blocosControlaveis` drive. Scripts that are stopped need plug-ins of others, or modules that are missing.\n",
        _table(("file", "fastest part", "scripts stopped", "ran 30 s", "of real time"), rows),
        f"Slower than {1000 * REST:g} mm/s, with no script stopped and less than {100 * SLOW:g} % of real time:\n"
        f"{_names(resting)}.\n",
    ]


def _names(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(prog="python -m bench.motion", description=__doc__)
    parser.add_argument("--samples", type=Path, help="folder with scenes of V-REP")
    parser.add_argument("--stock", type=Path, help="V-REP's folder `models`")
    chosen = parser.parse_args(arguments)
    logging.basicConfig(level=logging.ERROR)
    PAGE.write_text(page(chosen.samples, chosen.stock), encoding="utf-8")


if __name__ == "__main__":
    main()
