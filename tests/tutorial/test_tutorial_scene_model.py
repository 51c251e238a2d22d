"""The tutorial scene with its joints, without a server: kinematics, names, motors, gripper, grasp.

The expected numbers are V-REP's, read from the decoded tutorial scene, or those of the real UR5.
"""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from simx_server.scene.formats.loader import load_scene
from simx_server.simulation.simulation import Simulation

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]

SCENES = Path(__file__).parents[2] / "scenes"
BASE = np.array([0.325, 0.35, 0.0])
ZERO = np.zeros(6)
RESET = np.radians([90.0, -45.0, 90.0, 0.0, -100.0, 0.0])
GRASP = np.radians([78.0, 12.2, 110.7, -32.9, -90.0, -12.0])
JOINTS = [f"UR5_joint{i}" for i in range(1, 7)]


class Rig:
    """A scene whose joints alone are stepped, without scripts and clients."""

    def __init__(self, scene: str) -> None:
        self.sim = Simulation()
        self.sim.use(*load_scene(SCENES / scene))
        self.model, self.data = self.sim.model, self.sim.data
        self.arm = [self.sim.scene.resolve(name) for name in JOINTS]
        self.gripper = self.sim.scene.resolve("RG2_openCloseJoint")
        self.qpos = np.array([self.model.joint(name).qposadr[0] for name in JOINTS])
        self.dofs = np.array([self.model.joint(name).dofadr[0] for name in JOINTS])
        self.motors = np.array([self.model.actuator(name).id for name in JOINTS])
        self.gripper_motor = self.model.actuator("RG2_openCloseJoint").id
        self.tendon = self.model.tendon("RG2_openCloseJoint").id
        self.offset = float(annotations(self.model)["simx:joint:RG2_openCloseJoint"]["offset"])

    def place(self, angles: Array) -> None:
        """Put the arm at joint `angles` (radians), at rest."""
        self.data.qpos[self.qpos] = angles
        self.data.qvel[self.dofs] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def run(self, target: Array, seconds: float, finger_velocity: float = 0.0) -> tuple[Array, Array]:
        """Drive the arm to `target` (radians); return all joint angles (n, 6) and gripper positions (n,)."""
        joints = self.sim.joints
        for handle, angle in zip(self.arm, target.tolist(), strict=True):
            joints.set_target_position(handle, angle)
        joints.set_target_velocity(self.gripper, finger_velocity)
        angles, openings = [], []
        for _ in range(round(seconds / self.model.opt.timestep)):
            joints.controllers.step(1)
            angles.append(self.data.qpos[self.qpos].copy())
            openings.append(self.opening)
        return np.array(angles), np.array(openings)

    @property
    def opening(self) -> float:
        """Position of RG2_openCloseJoint in metres: 0 as saved, positive open."""
        return float(self.data.ten_length[self.tendon] + self.offset)


def annotations(model: mujoco.MjModel) -> dict[str, dict[str, str]]:
    """Every custom text as {name: {key: value}}."""
    found = {}
    for i in range(model.ntext):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, i)
        start, size = model.text_adr[i], model.text_size[i]
        data = bytes(model.text_data[start : start + size - 1]).decode()
        found[name] = dict(pair.split("=") for pair in data.split())
    return found


def denavit_hartenberg(q_dh: Array) -> Array:
    """UR5 (CB3) flange in the base frame, 4x4, metres. Lengths: ros-industrial ur_description, UR5."""
    lengths_d = (0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823)
    lengths_a = (0.0, -0.425, -0.39225, 0.0, 0.0, 0.0)
    twists = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)
    pose = np.eye(4)
    for theta, d, a, alpha in zip(q_dh, lengths_d, lengths_a, twists, strict=True):
        (ct, st), (ca, sa) = (np.cos(theta), np.sin(theta)), (np.cos(alpha), np.sin(alpha))
        pose = pose @ np.array(
            [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        )
    return pose


@pytest.fixture(scope="module")
def rig() -> Rig:
    return Rig("ur5_rg2_kinect.xml")


@pytest.fixture
def fresh(rig: Rig) -> Rig:
    """The tutorial scene as loaded: arm at zero, objects as saved."""
    rig.sim.stop()
    rig.sim.start()
    mujoco.mj_forward(rig.model, rig.data)
    return rig


def test_flange_follows_the_denavit_hartenberg_table(fresh: Rig) -> None:
    poses = [ZERO, RESET, *np.random.default_rng(1).uniform(-np.pi, np.pi, (20, 6))]
    for q in poses:
        fresh.place(q)
        expected = denavit_hartenberg(q + np.radians([-90, -90, 0, -90, 0, 0]))
        rg2, link7 = fresh.data.body("RG2"), fresh.data.body("UR5_link7")
        tool = link7.xmat.reshape(3, 3)[:, 2]
        # Joint 6's frame stands 13.57 mm behind joint 5's axis, the flange 82.3 mm in front of it.
        assert link7.xpos + tool * (0.0823 + 0.01357) == pytest.approx(BASE + expected[:3, 3], abs=1e-4)
        assert rg2.xmat.reshape(3, 3) == pytest.approx(expected[:3, :3], abs=1e-6)


@pytest.mark.parametrize(
    ("joint", "position", "axis", "x_axis"),
    [
        ("UR5_joint1", (0, 0, 0.0231), (0, 0, 1), (1, 0, 0)),
        ("UR5_joint2", (-0.0703, 0, 0.0892), (-1, 0, 0), (0, 0, 1)),
        ("UR5_joint3", (-0.0703, 0, 0.5143), (-1, 0, 0), (0, 0, 1)),
        ("UR5_joint4", (-0.0703, 0, 0.9064), (-1, 0, 0), (0, 0, 1)),
        ("UR5_joint5", (-0.1100, 0, 0.9520), (0, 0, 1), (1, 0, 0)),
        ("UR5_joint6", (-0.0956, 0, 1.0012), (-1, 0, 0), (0, 0, 1)),
    ],
)
def test_joint_frames_at_zero_are_those_of_vrep(
    fresh: Rig, joint: str, position: tuple[float, ...], axis: tuple[float, ...], x_axis: tuple[float, ...]
) -> None:
    body = fresh.data.xmat[fresh.model.joint(joint).bodyid[0]].reshape(3, 3)
    # V-REP's own axes stand up to 0.85 mm beside the Denavit-Hartenberg ones (joint 5).
    assert fresh.data.joint(joint).xanchor - BASE == pytest.approx(position, abs=1e-3)
    assert fresh.data.joint(joint).xaxis == pytest.approx(axis, abs=1e-6)
    assert body[:, 2] == pytest.approx(axis, abs=1e-6)
    assert body[:, 0] == pytest.approx(x_axis, abs=1e-6)


TREE = """
    world: UR5 ResizableFloor_5_25 DefaultLights XYZCameraProxy
    world: Target Cuboid Cuboid0 Cuboid1 Cuboid2 Cylinder Cylinder0
    ResizableFloor_5_25: ResizableFloor_5_25_element
    ResizableFloor_5_25_element: ResizableFloor_5_25_visibleElement
    UR5: UR5_link1_visible UR5_link2
    UR5_link2: UR5_link2_visible UR5_link3
    UR5_link3: UR5_link3_visible UR5_link4
    UR5_link4: UR5_link4_visible UR5_link5
    UR5_link5: UR5_link5_visible UR5_link6
    UR5_link6: UR5_link6_visible UR5_link7
    UR5_link7: UR5_link7_visible RG2
    RG2: RG2_upperBase RG2_baseVisible RG2_centerAuxMass DetectionCamera
    RG2: RG2_leftLink0 RG2_leftLink2 RG2_rightLink0 RG2_rightLink2
    RG2_leftLink0: RG2_leftLink0_visible RG2_leftLink1
    RG2_leftLink1: RG2_leftLink1_visible RG2_leftTouch
    RG2_leftLink2: RG2_leftLink2_visible RG2_leftAuxMass
    RG2_rightLink0: RG2_rightLink0_visible RG2_rightLink1
    RG2_rightLink1: RG2_rightLink1_visible RG2_rightTouch
    RG2_rightLink2: RG2_rightLink2_visible RG2_rightAuxMass
    RG2_centerAuxMass: RG2_centerLoopDummyA
"""


@pytest.mark.parametrize("line", TREE.strip().splitlines())
def test_every_object_of_the_tutorial_tree_hangs_where_it_should(fresh: Rig, line: str) -> None:
    parent, children = line.strip().split(": ")
    for child in children.split():
        assert fresh.model.body(fresh.model.body(child).parentid[0]).name == parent, child


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("joint", JOINTS),
        ("joint", [f"RG2_{side}Joint{i}" for side in ("left", "right") for i in range(4)]),
        ("joint", ["RG2_centerJoint0", "RG2_centerJoint1"]),
        ("tendon", ["RG2_openCloseJoint"]),
        ("actuator", [*JOINTS, "RG2_openCloseJoint"]),
        ("site", ["UR5_connection", "UR5_ikTip", "UR5_ikTarget", "UR5_tip", "UR5_target"]),
        ("site", ["RG2_attachPoint", "RG2_attachProxSensor", "RG2_lowerUpperBaseConnection"]),
        ("site", ["RG2_leftForceSensor", "RG2_rightForceSensor", "RG2_leftLoopDummyA", "RG2_leftLoopDummyB"]),
        ("site", ["RG2_rightLoopDummyA", "RG2_rightLoopDummyB", "RG2_openCloseLoopDummyA"]),
        ("site", ["RG2_openCloseLoopDummyB", "RG2_centerLoopDummyB"]),
        ("camera", ["kinect_rgb", "kinect_depth", "Camera", "DefaultCamera", "DefaultNZViewCamera"]),
        ("light", ["DefaultLightA", "DefaultLightB", "DefaultLightC", "DefaultLightD"]),
    ],
)
def test_names_scripts_ask_for_exist(fresh: Rig, kind: str, names: list[str]) -> None:
    for name in names:
        assert getattr(fresh.model, kind)(name).name == name


def test_every_annotation_names_something_of_the_scene(fresh: Rig) -> None:
    joints = (mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_TENDON)
    kinds = {
        "joint": joints,
        "vision": (mujoco.mjtObj.mjOBJ_CAMERA,),
        "camera": (mujoco.mjtObj.mjOBJ_CAMERA,),
        "proximity": (mujoco.mjtObj.mjOBJ_SITE,),
        "script": (mujoco.mjtObj.mjOBJ_BODY,),
        "model": (mujoco.mjtObj.mjOBJ_BODY,),
        "ros2": (mujoco.mjtObj.mjOBJ_BODY,),
        "object": (mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_SITE, *joints),
    }
    found = annotations(fresh.model)
    for annotation in found:
        prefix, kind, name = annotation.split(":")
        assert prefix == "simx"
        assert any(mujoco.mj_name2id(fresh.model, obj, name) >= 0 for obj in kinds[kind]), name
    assert (SCENES / "models" / found["simx:script:RG2"]["file"]).is_file()


def test_what_cameras_see_is_felt_by_nothing_on_the_robot(fresh: Rig) -> None:
    model = fresh.model
    for geom in range(model.ngeom):
        name = model.body(model.geom_bodyid[geom]).name
        if name.startswith(("UR5", "RG2")):
            solid = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
            assert not (solid and model.geom_group[geom] < 3), name


@pytest.mark.parametrize("camera", ["kinect_rgb", "kinect_depth"])
def test_hand_camera_at_zero_looks_level_along_minus_x(fresh: Rig, camera: str) -> None:
    pose = fresh.data.camera(camera)
    right, up, back = pose.xmat.reshape(3, 3).T
    # 0.15 mm: V-REP's joint 6 stands that much above the Denavit-Hartenberg axis.
    assert pose.xpos == pytest.approx([0.00175, 0.35090, 1.04489], abs=2e-4)
    assert right == pytest.approx([0, 1, 0], abs=1e-6)
    assert up == pytest.approx([0, 0, 1], abs=1e-6)
    assert back == pytest.approx([1, 0, 0], abs=1e-6)
    assert tuple(fresh.model.cam_resolution[pose.id]) == (640, 480)
    across = 2 * np.arctan(np.tan(np.radians(fresh.model.cam_fovy[pose.id]) / 2) * 640 / 480)
    assert np.degrees(across) == pytest.approx(57.0, abs=1e-3)


def test_ball_is_in_the_hand_cameras_view_at_the_reset_pose(fresh: Rig) -> None:
    fresh.place(RESET)
    camera = fresh.data.camera("kinect_rgb")
    x, y, z = camera.xmat.reshape(3, 3).T @ (fresh.data.body("Target").xpos - camera.xpos)
    focal = 240 / np.tan(np.radians(44.3140 / 2))
    column, row = 320 + focal * x / -z, 240 - focal * y / -z
    assert z < 0
    assert (column, row) == pytest.approx((118.5, 194.9), abs=0.5)


def test_loose_objects_come_to_rest_and_the_ball_keeps_hovering(fresh: Rig) -> None:
    fresh.run(ZERO, 1.0)
    expected = {
        "Target": (-0.525, 0.15, 0.075), "Cuboid0": (-0.85, -0.5, 0.1), "Cuboid": (-0.325, -0.9, 0.05),
        "Cuboid1": (0.4, -0.725, 0.05), "Cuboid2": (-0.8, 0.125, 0.05), "Cylinder": (0.325, -0.35, 0.075),
        "Cylinder0": (-0.644, 0.274, 0.1),
    }  # fmt: skip
    for name, position in expected.items():
        assert fresh.data.body(name).xpos == pytest.approx(position, abs=1e-4), name
        assert np.linalg.norm(fresh.data.body(name).cvel) < 1e-3, name


@pytest.mark.parametrize("joint", range(6))
def test_one_degree_step_settles_without_overshoot(fresh: Rig, joint: int) -> None:
    fresh.place(RESET)
    fresh.run(RESET, 0.2)
    start = fresh.data.qpos[fresh.qpos].copy()
    target = start.copy()
    target[joint] += np.radians(1.0)
    angles, _ = fresh.run(target, 0.6)
    moved = np.degrees(angles - start)
    settled = round(0.25 / fresh.model.opt.timestep)
    assert np.abs(moved[settled:, joint] - 1.0).max() < 0.02
    assert moved[:, joint].max() < 1.0 + 1e-4
    assert np.abs(np.delete(moved, joint, axis=1)).max() < 0.05


@pytest.mark.parametrize("joint", range(6))
def test_reversing_at_full_speed_does_not_chatter_at_the_torque_limit(fresh: Rig, joint: int) -> None:
    target = np.zeros(6)
    flips = 0
    for goal in (0.8, -0.8, 0.8):
        target[joint] = goal
        for _ in range(100):
            before = float(fresh.data.actuator_force[fresh.motors[joint]])
            fresh.run(target, fresh.model.opt.timestep)
            flips += abs(fresh.data.actuator_force[fresh.motors[joint]] - before) > 200
    # Braking from full speed is one change of sign; a limit cycle would be one per step.
    assert flips <= 6


def test_arm_reaches_the_reset_pose_from_zero_touching_nothing(fresh: Rig) -> None:
    angles, _ = fresh.run(RESET, 1.0)
    assert np.degrees(np.abs(angles[-1] - RESET)).max() < 0.1
    robot = {i for i in range(fresh.model.nbody) if fresh.model.body(i).name.startswith(("UR5", "RG2"))}
    touching = {int(fresh.model.geom_bodyid[g]) for g in fresh.data.contact.geom.ravel()}
    assert not robot & touching


def test_gripper_strokes_to_both_ends_and_its_fingers_stay_parallel(fresh: Rig) -> None:
    low, high = fresh.model.tendon_range[fresh.tendon] + fresh.offset
    assert (low, high) == pytest.approx((-0.048, 0.0538))
    assert fresh.opening == pytest.approx(0.0, abs=1e-6)

    def tips_turned() -> float:
        hand = fresh.data.body("RG2").xmat.reshape(3, 3)
        tips = (fresh.data.body(f"RG2_{side}Touch").xmat.reshape(3, 3) for side in ("left", "right"))
        return max(float(np.abs(tip - hand).max()) for tip in tips)

    ends = []
    for velocity, seconds in ((0.05, 1.3), (-0.05, 2.3), (0.05, 2.3)):
        slices = [fresh.run(ZERO, seconds / 20, velocity)[1] for _ in range(20) if tips_turned() < 2e-3]
        assert len(slices) == 20, "a fingertip turned"
        ends.append(slices[-1][-1])
    opened, closed, reopened = ends
    assert closed < -0.047
    assert opened == pytest.approx(0.0538, abs=5e-4)
    assert reopened > 0.0536


def test_finger_speed_is_the_commanded_one_and_both_fingers_share_it(fresh: Rig) -> None:
    _, openings = fresh.run(ZERO, 0.5, 0.05)
    assert openings[-1] - openings[round(0.2 / fresh.model.opt.timestep) - 1] == pytest.approx(
        0.05 * (0.5 - 0.2), rel=0.02
    )
    hand = fresh.data.body("RG2")
    left, right = (
        (hand.xmat.reshape(3, 3).T @ (fresh.data.body(f"RG2_{side}Touch").xpos - hand.xpos))[0]
        for side in ("left", "right")
    )
    assert left == pytest.approx(-right, abs=2e-5)
    assert fresh.data.joint("RG2_centerJoint1").qpos[0] == pytest.approx(-fresh.opening / 2, abs=2e-4)


def test_velocity_zero_holds_the_opening(fresh: Rig) -> None:
    fresh.run(ZERO, 0.4, 0.05)
    before = fresh.opening
    fresh.run(RESET, 1.0, 0.0)
    assert fresh.opening == pytest.approx(before, abs=1e-3)


def test_ball_is_grasped_lifted_and_held_for_five_seconds() -> None:
    rig = Rig("ur5_rg2_kinect_ball.xml")
    rig.run(ZERO, 1.3, 0.05)
    rig.place(GRASP)
    rig.run(GRASP, 1.5, -0.05)
    assert rig.opening == pytest.approx(0.0028, abs=1e-3)  # 50 mm between pads that are 47.2 mm apart at 0
    assert rig.data.actuator_force[rig.gripper_motor] == pytest.approx(-20.0)

    ball, tip = rig.data.body("Ball"), rig.data.site("UR5_ikTip")

    def in_hand() -> Array:
        return tip.xmat.reshape(3, 3).T @ (ball.xpos - tip.xpos)

    lifted = GRASP - np.radians([0.0, 25.0, 0.0, 0.0, 0.0, 0.0])
    for share in np.linspace(0.05, 1.0, 20):
        rig.run(GRASP + share * (lifted - GRASP), 0.05, -0.05)
    rig.run(lifted, 0.5, -0.05)
    before = in_hand()
    assert ball.xpos[2] > 0.2
    rig.run(lifted, 5.0, -0.05)
    assert np.linalg.norm(in_hand() - before) < 1e-4


def test_ray_between_the_fingers_sees_nothing_but_what_is_to_be_grasped(fresh: Rig) -> None:
    assert fresh.data.sensordata[-1] == -1.0
    rig = Rig("ur5_rg2_kinect_ball.xml")
    rig.run(ZERO, 1.3, 0.05)
    rig.place(GRASP)
    sensor = rig.data.site("RG2_attachProxSensor")
    depth = sensor.xmat.reshape(3, 3)[:, 2] @ (rig.data.body("Ball").xpos - sensor.xpos)
    assert rig.data.sensordata[-1] == pytest.approx(depth - 0.025, abs=1e-4)


def test_stock_kinect_stands_on_the_floor_and_looks_along_y() -> None:
    model = mujoco.MjModel.from_xml_path(str(SCENES / "stock_kinect.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 500)
    root = data.body("kinect").xpos * [1, 1, 0]
    for name in ("kinect_rgb", "kinect_depth"):
        assert data.camera(name).xpos - root == pytest.approx([-0.0141, 0.0293, 0.053], abs=1e-5)
        assert -data.camera(name).xmat.reshape(3, 3)[:, 2] == pytest.approx([0, 1, 0], abs=1e-5)
