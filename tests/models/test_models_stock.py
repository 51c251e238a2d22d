"""Stock models and their copies are as V-REP has them, and the shipped scenes stand still."""

from __future__ import annotations

import arm_stock
import pytest
from manipulators_stock import YOUBOT
from model_checks import Stock, check_copies, check_idle, check_stock
from real_world import Open, start_stepped
from scanner_stock import SCANNER
from small_stock import E_PUCK, NAO
from small_wheeled_stock import DR12, K_JUNIOR, KHEPERA, LUMIBOT
from vehicles_stock import ACKERMANN, MANTA, QUADRICOPTER
from wheeled_stock import BUBBLE_ROB, LINE_TRACER, PIONEER, REMOTE_BUBBLE_ROB

pytestmark = pytest.mark.slow

ROBOTS: dict[str, tuple[Stock, ...]] = {
    "KUKA YouBot": YOUBOT,
    "line follower": LINE_TRACER,
    "e-puck": E_PUCK,
    "NAO": NAO,
    "dr12": DR12,
    "lumibot": LUMIBOT,
    "K-Junior": K_JUNIOR,
    "Khepera III": KHEPERA,
    "Quadricopter": QUADRICOPTER,
    "pioneer p3dx": PIONEER,
}
MODELS = {
    **arm_stock.MODELS,
    **{f"models/robots/mobile/{name}.ttm": rows for name, rows in ROBOTS.items()},
    "models/vehicles/simple Ackermann steering.ttm": ACKERMANN,
    "models/vehicles/Manta with differential.ttm": MANTA,
    "models/components/sensors/Hokuyo URG 04LX UG01_Fast.ttm": SCANNER,
    "bubbleRob.ttm": BUBBLE_ROB,
    "remoteApiControlledBubbleRob.ttm": REMOTE_BUBBLE_ROB,
}
"""By stock file name."""

STILL: dict[str, tuple[str, ...]] = {
    **{file: tuple(row.name for row in rows) for file, rows in arm_stock.MODELS.items()},
    "models/components/sensors/Hokuyo URG 04LX UG01_Fast.ttm": ("fastHokuyo", "fastHokuyo_sensor1"),
    "models/robots/mobile/dr12.ttm": ("dr12", "dr12_leftJoint_"),
    "models/robots/mobile/lumibot.ttm": ("lumibot", "lumibot_leftMotor"),
    "models/robots/mobile/K-Junior.ttm": ("KJunior", "KJunior_motorLeft"),
    "models/robots/mobile/Khepera III.ttm": ("K3_robot", "K3_leftWheelMotor"),
}
"""Objects of models without a scene that stand still."""

SCENES: dict[str, tuple[str, ...]] = {
    **{scene: tuple(row.name for row in rows) for scene, rows in arm_stock.SCENES.items()},
    "youbot": ("youBot", "youBotGripperJoint2", "youBot_positionTip", "Cube"),
    "line_tracer": ("LineTracer", "DynamicLeftJoint", "LeftJoint", "DynamicSlider"),
    "e_puck": ("ePuck", "ePuck_leftRespondableWheel", "ePuck_topPart"),
    "nao": ("NAO", "NAO_head", "NAO_leftHand", "NAO_rightFoot"),
    "quadricopter": ("Quadricopter", "Quadricopter_target", "Quadricopter_propeller_respondable1"),
    "ackermann_line": ("nakedAckermannSteeringCar", "nakedCar_frontLeftWheel_respondable", "Vision_sensor"),
    "pioneer_p3dx": ("Pioneer_p3dx", "Pioneer_p3dx_leftMotor", "Pioneer_p3dx_caster_wheel"),
    "bubblerob": ("remoteApiControlledBubbleRob", "remoteApiControlledBubbleRobLeftMotor"),
    "bubblerob_tutorial": ("bubbleRob", "bubbleRob_leftMotor"),
    "inverted_pendulum": ("pendulum_bob",),
    "cart_pole": ("cart",),
    "two_link_arm": ("link2", "tip"),
}
"""Objects of each shipped scene that stand still."""


@pytest.mark.parametrize("file", MODELS)
def test_model_and_its_copy_are_vreps(world: Open, file: str) -> None:
    opened, client = world("stock_kinect")
    check_copies(
        opened,
        client,
        file,
        MODELS[file],
        at=(5.0, 5.5) if file.startswith("models/vehicles") else (1.0, 1.5),
    )
    if file in STILL:
        start_stepped(client)
        # RG2 opens when the simulation starts.
        check_idle(client, [name + suffix for name in STILL[file] for suffix in ("", "#0")], 8.0, 3.0)


@pytest.mark.parametrize("scene", SCENES)
def test_scene_stands_still_for_ten_seconds(world: Open, scene: str) -> None:
    opened, client = world(scene)
    if scene in arm_stock.SCENES:
        check_stock(opened, client, arm_stock.SCENES[scene])
    start_stepped(client)
    check_idle(client, SCENES[scene], settling=2.0)
