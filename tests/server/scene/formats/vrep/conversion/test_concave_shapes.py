"""Files with shapes that are not convex, as worlds: what is in the way, and what is not."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from vrep_concave import bowl, room
from vrep_writer import VrepWriter

from simx_server.scene.formats.vrep.conversion.geometry.colliding import decomposition
from simx_server.scene.formats.vrep.conversion.shapes import HIDDEN
from simx_server.scene.formats.vrep.opening import open_vrep

At = tuple[float, float, float]


class File(VrepWriter):
    """A scene of balls among other shapes."""

    def __init__(self) -> None:
        super().__init__(21)
        self.balls: list[str] = []

    def ball(self, at: At, radius: float = 0.1) -> None:
        """Add a ball of 1 kg that rolls and falls."""
        self.balls.append(f"ball{len(self.balls)}")
        moment = 0.4 * radius**2
        self.shape(
            self.balls[-1], spheroid=(2 * radius,) * 3, position=at, dynamic=True, respondable=True,
            inertia=(moment, moment, moment),
        )  # fmt: skip

    def model(self) -> mujoco.MjModel:
        self.settings()
        spec, report, _ = open_vrep(self.bytes(), "made.ttt")
        assert not report.approximated
        return spec.compile()

    def after(self, seconds: float, *, velocities: dict[int, At] | None = None) -> np.ndarray:
        """Where the balls are after some time."""
        model = self.model()
        data = mujoco.MjData(model)
        for ball, velocity in (velocities or {}).items():
            joint = model.body_dofadr[model.body(self.balls[ball]).id]
            data.qvel[joint : joint + 3] = velocity
        for _ in range(round(seconds / model.opt.timestep)):
            mujoco.mj_step(model, data)
        return np.array([data.body(name).xpos for name in self.balls])


@pytest.fixture(autouse=True)
def without(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the library that decomposes meshes: none of this needs it."""
    monkeypatch.setattr(decomposition, "is_available", lambda: False)


@pytest.mark.parametrize("lean", [0.0, 0.2])
def test_balls_in_a_room_stay_leave_by_the_doorway_and_stop_at_the_walls(lean: float) -> None:
    points, faces = room()
    points[:, 1] -= np.float32(lean) * points[:, 2]  # then it consists of no boxes
    file = File()
    file.shape("floor", cuboid=(6, 6, 0.2), position=(0, 0, -0.1), respondable=True)
    file.shape("walls", mesh=(points, faces), respondable=True)
    for at in ((0, 0.5, 0.1), (0, -0.5, 0.1), (0.7, 0.0, 0.1), (-0.7, 0.0, 0.1)):
        file.ball(at)
    away = file.after(1.0, velocities={1: (0, -2, 0), 2: (2, 0, 0), 3: (0, 2, 0)})
    assert away[0] == pytest.approx([0, 0.5, 0.1], abs=2e-3), "nothing pushes it"
    assert away[1, 1] < -1.3, "it is outside"
    assert away[2, 0] < 0.91
    assert away[3, 1] < 0.91
    assert (away[:, 2] < 0.15).all()


@pytest.mark.parametrize("radius", [0.02, 0.1])
def test_ball_that_falls_from_high_does_not_fall_through_a_thin_bowl(radius: float) -> None:
    file = File()
    file.shape("bowl", mesh=bowl(), respondable=True)
    file.ball((0.05, 0.02, 2.0), radius)
    ((x, y, z),) = file.after(4.0)
    assert np.hypot(x, y) < 0.3
    assert -0.49 + radius - 0.02 < z < -0.1


def test_parts_that_are_boxes_become_boxes() -> None:
    points, faces = room()
    beside = points + np.array([5, 0, 0], np.float32)
    beside[:, 0] += beside[:, 2]
    file = File()
    file.shape(
        "walls", mesh=(np.concatenate([points, beside]), np.concatenate([faces, faces + len(points)])),
        respondable=True,
    )  # fmt: skip
    model = file.model()
    types = model.geom_type[model.geom_group == HIDDEN]
    assert (types == int(mujoco.mjtGeom.mjGEOM_BOX)).sum() >= 5
    assert model.ngeom < 1 + 5 + 30


def channel() -> tuple[np.ndarray, np.ndarray]:
    """A trough with a U as its section, along y, open above: 0.5 m wide, walls of 5 cm."""
    section = [
        (-0.25, 0),
        (0.25, 0),
        (0.25, 0.2),
        (0.2, 0.2),
        (0.2, 0.05),
        (-0.2, 0.05),
        (-0.2, 0.2),
        (-0.25, 0.2),
    ]
    points = np.array([(x, y, z) for y in (-0.2, 0.2) for x, z in section])
    lid = [(0, 5, 6), (0, 6, 7), (0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4)]
    faces = [face for a, b, c in lid for face in ((a, b, c), (c + 8, b + 8, a + 8))]
    for a in range(8):
        b = (a + 1) % 8
        faces += [(a, a + 8, b + 8), (a, b + 8, b)]
    return points, np.array(faces)


def test_ball_sits_in_a_moving_trough() -> None:
    file = File()
    file.shape("floor", cuboid=(6, 6, 0.2), position=(0, 0, -0.1), respondable=True)
    file.shape(
        "trough", mesh=channel(), dynamic=True, respondable=True, mass=5.0, inertia=(0.02, 0.02, 0.02),
        center=(0, 0, 0.08),
    )  # fmt: skip
    file.ball((0.0, 0.0, 0.3), 0.05)
    assert file.after(1.0)[0] == pytest.approx([0, 0, 0.1], abs=0.01)
