"""Drives and rings that are guessed for robots without annotation: commands, odometry, scans, and the flag."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from processes import ROOT
from real_world import BLOCKING
from ros2_contents import Contents

import simx_client as v
from simx_server.gateways.ros2.annotated.steering import STEEPEST, Steer, angle, limited, speed

MODELS = ROOT / "scenes" / "models"


def bare(folder: Path, model: str) -> Path:
    """Return a scene of a shipped model without its annotation for ROS 2, on a floor."""
    text = (MODELS / f"{model}.xml").read_text(encoding="utf-8")
    text = re.sub(r'<text name="simx:ros2:[^>]*/>', "", text)
    text = text.replace("<worldbody>", '<worldbody><geom name="ground" type="plane" size="20 20 .1"/>', 1)
    path = folder / f"{model}.xml"
    path.write_text(text.replace('file="', f'file="{MODELS}/').replace(f'file="{MODELS}//', 'file="/'))
    return path


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[Any]:
    made: list[Contents] = []

    def open_scene(model: str, drive: str | None = None) -> Contents:
        made.append(Contents(bare(tmp_path, model), drive))
        return made[-1]

    yield open_scene
    for each in made:
        each.close()


def guess(contents: Contents) -> dict[str, Any]:
    (note,) = contents.robots.guessed.values()
    return dict(note)


@pytest.mark.parametrize(
    ("model", "kind", "left", "forward"),
    [
        ("pioneer_p3dx", "diff", "Pioneer_p3dx_leftMotor", "x"),
        ("dr12", "diff", "dr12_leftJoint_", None),
        ("e_puck", "diff", "ePuck_leftJoint", None),
        ("khepera_iii", "diff", "K3_leftWheelMotor", None),
        ("kuka_youbot", "mecanum", None, None),
        ("simple_ackermann_steering", "ackermann", None, None),
    ],
)
def test_the_drive_of_a_robot_is_guessed_and_logged(
    opened: Any,
    caplog: pytest.LogCaptureFixture,
    model: str,
    kind: str,
    left: str | None,
    forward: str | None,
) -> None:
    caplog.set_level(logging.INFO)
    contents = opened(model)
    note = guess(contents)
    assert note["drive"] == kind
    assert {"/cmd_vel", "/odom"} <= contents.topics()
    assert left is None or note["left"] == left
    assert forward is None or note["forward"] == forward
    assert f"drive={kind}" in caplog.text
    contents.offers()
    assert caplog.text.count("guessed from joints") == 1


def test_the_guess_is_the_annotation_of_the_shipped_pioneer(opened: Any) -> None:
    contents = opened("pioneer_p3dx")
    note = guess(contents)
    assert note["radius"] == pytest.approx(0.0975, abs=0.001)
    assert note["scan"] == "/scan"
    assert "/scan" in contents.topics()


def drive(contents: Contents, vx: float, w: float, steps: int) -> tuple[float, float, float]:
    """Return x, y and heading of the odometry after a drive."""
    contents.start()
    for _ in range(steps):
        contents.send("/cmd_vel", {"linear": {"x": vx}, "angular": {"z": w}}, "Twist")
        contents.step()
    pose = contents.message("/odom")["pose"]["pose"]
    turn = pose["orientation"]
    return pose["position"]["x"], pose["position"]["y"], 2 * math.atan(turn["z"] / turn["w"])


def test_a_guessed_base_drives_forward_and_turns_left(opened: Any) -> None:
    x, y, _ = drive(opened("dr12"), 0.1, 0.0, 40)
    assert x == pytest.approx(0.2, rel=0.15)
    assert abs(y) < 0.02
    _, _, heading = drive(opened("pioneer_p3dx"), 0.0, 0.5, 40)
    assert heading == pytest.approx(1.0, rel=0.2)


def test_a_car_drives_on_the_circle_of_its_command(opened: Any) -> None:
    contents = opened("simple_ackermann_steering")
    note = guess(contents)
    assert set(note["steer"].split(",")) == {"nakedCar_steeringLeft", "nakedCar_steeringRight"}
    x, y, heading = drive(contents, 1.5, 0.3, 60)
    assert heading == pytest.approx(0.9, rel=0.25)
    assert x > 2
    assert y > 0.5


def test_only_the_robot_that_the_flag_names_is_guessed(opened: Any, caplog: pytest.LogCaptureFixture) -> None:
    assert "/cmd_vel" not in opened("dr12", "off").topics()
    assert "/cmd_vel" in opened("dr12", "dr12").topics()
    assert "/cmd_vel" not in opened("dr12", "nobody").topics()
    assert "--ros2-drive names 'nobody'" in caplog.text


def test_a_robot_without_wheels_has_no_drive_and_the_reason_is_logged(
    opened: Any, caplog: pytest.LogCaptureFixture
) -> None:
    contents = opened("abb_irb_140", "IRB140")
    assert "/cmd_vel" not in contents.topics()
    assert "less than two wheels" in caplog.text


CART = """<mujoco><compiler angle="radian"/><worldbody>
<geom type="plane" size="9 9 .1"/>
<body name="cart" pos="0 0 .2" euler="0 0 {heading}"><freejoint/><geom type="box" size=".2 .1 .05" mass="5"/>
<body name="a" pos="0 .2 -.1"><joint name="port" axis="0 1 0"/>
<geom type="{shape}" size="{left}" euler="1.5708 0 0"/></body>
<body name="b" pos="0 -.2 -.1"><joint name="starboard" axis="0 {mirrored} 0"/>
<geom type="cylinder" size=".1 .02" euler="1.5708 0 0"/></body></body></worldbody><custom>
<text name="simx:model:cart" data="base=yes"/>
<text name="simx:joint:port" data="motor=on control=velocity max_force=9"/>
<text name="simx:joint:starboard" data="motor=on control=velocity max_force=9"/>
</custom></mujoco>"""


def cart(
    folder: Path, *, heading: float = 0.0, mirrored: int = 1, shape: str = "cylinder", left: str = ".1 .02"
) -> Contents:
    path = folder / "cart.xml"
    path.write_text(CART.format(heading=heading, mirrored=mirrored, shape=shape, left=left))
    return Contents(path, "cart")


@pytest.mark.parametrize("heading", [0.0, 1.5708, 3.1416, 4.7124])
def test_a_robot_with_mirrored_motors_has_the_same_front_wherever_it_looks(
    tmp_path: Path, heading: float
) -> None:
    contents = cart(tmp_path, heading=heading, mirrored=-1)
    note = guess(contents)
    assert (note["forward"], note["left"], note["right"]) == ("x", "port", "starboard")
    contents.close()


def test_a_robot_that_turns_over_keeps_its_drive_until_the_run_ends(tmp_path: Path) -> None:
    contents = cart(tmp_path)
    note = guess(contents)
    contents.start()
    handle = contents.handle("cart")
    over = [math.pi / 2, 0.0, 0.0]
    assert v.simxSetObjectOrientation(contents.cid, handle, -1, over, BLOCKING) == v.simx_return_ok
    contents.offers()
    assert guess(contents) == note
    v.simxStopSimulation(contents.cid, BLOCKING)
    assert v.simxSetObjectOrientation(contents.cid, handle, -1, over, BLOCKING) == v.simx_return_ok
    contents.offers()
    assert not contents.robots.guessed
    contents.close()


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"left": ".05 .02"}, "radii from 0.05 to 0.1 m"),
        ({"shape": "box", "left": ".1 .02 .02"}, "port is not round"),
    ],
)
def test_what_one_radius_does_not_describe_is_no_drive(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, wrong: Any, why: str
) -> None:
    contents = cart(tmp_path, **wrong)
    assert "/cmd_vel" not in contents.topics()
    assert why in caplog.text
    contents.close()


def test_rollers_that_stand_the_other_way_round_are_no_mecanum_drive(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = bare(tmp_path, "kuka_youbot")
    text = path.read_text()
    turned = re.sub(
        r'(slippingJoint_\w+" .*axis="0.70710678 )(-?)0',
        lambda found: f"{found[1]}{'' if found[2] else '-'}0",
        text,
    )
    assert turned != text
    path.write_text(turned)
    contents = Contents(path, "youBot")
    assert "the other way round" in caplog.text
    assert "/cmd_vel" not in contents.topics()
    contents.close()


# --- the geometry of the steering ----------------------------------------------------------------


def test_wheels_of_a_car_point_at_right_angles_to_its_turning_point() -> None:
    left, right = Steer(1, 2.0, 0.5, 1.0), Steer(2, 2.0, -0.5, -1.0)
    v, w = 2.0, 0.4  # the turning point is 5 m to the left
    assert angle(left, v, w) == pytest.approx(math.atan2(2.0, 4.5))
    assert angle(right, v, w) == pytest.approx(-math.atan2(2.0, 5.5))
    assert speed(2.0, 0.5, v, w) == pytest.approx(0.4 * math.hypot(2.0, 4.5))
    assert speed(2.0, 0.5, -v, -w) == pytest.approx(-0.4 * math.hypot(2.0, 4.5))


def test_a_car_does_not_turn_on_the_spot_nor_tighter_than_its_steering() -> None:
    steers = [Steer(1, 2.0, 0.5, 1.0)]
    assert limited(steers, 0.0, 3.0) == (0.0, 0.0)
    v, w = limited(steers, 1.0, 100.0)
    assert v == 1.0
    assert w == pytest.approx(math.tan(STEEPEST) / 2)
    assert limited(steers, -1.0, -100.0)[1] == pytest.approx(-w)
