"""Blocks that a program imports as meshes and drops, as table-top grasping programs do, come to rest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import mujoco
import numpy as np
import pytest
from handler_calls import World
from numpy.typing import NDArray
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step

import simx_client as vrep
from simx_server.editing.command_server import COMMAND_SERVER, add_command_server
from simx_server.scene.formats.loose_meshes import settle_loose_meshes

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]

PLAIN = '<mujoco model="plain"><worldbody><geom type="plane" size="3 3 0.1"/></worldbody></mujoco>'
"""A floor with MuJoCo's own settings, in which nothing sleeps."""

PLACE = (-0.8, -0.3)
"""Where the tutorial's floor is free."""

LEAST_CONTACT = 3e-4
"""Metres by which a body at rest may be in the floor or above it."""


def stack(*rings: Sequence[Sequence[float]]) -> tuple[Array, Array]:
    """A closed mesh of polygons above each other, of equally many corners: points (n, 3) and triangles (m, 3)."""
    count, last = len(rings[0]), len(rings) - 1
    faces: list[tuple[int, int, int]] = []
    for corner in range(1, count - 1):
        faces.append((0, corner + 1, corner))
        faces.append((last * count, last * count + corner, last * count + corner + 1))
    for ring in range(last):
        for corner in range(count):
            a, b = ring * count + corner, ring * count + (corner + 1) % count
            faces += [(a, b, b + count), (a, b + count, a + count)]
    return np.array(rings, float).reshape(-1, 3), np.array(faces)


def polygon(count: int, radius: float, z: float) -> list[tuple[float, float, float]]:
    turns = [2 * math.pi * k / count for k in range(count)]
    return [(radius * math.cos(turn), radius * math.sin(turn), z) for turn in turns]


def rectangle(x: float, y: float, z: float) -> list[tuple[float, float, float]]:
    return [(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]


def blocks() -> dict[str, tuple[Array, Array]]:
    """Eight blocks of a few centimetres: points in metres, and triangles. Those at the end are irregular."""
    skew = np.array([[0.021, 0.006, 0.0], [0.0, 0.028, 0.004], [0.003, 0.0, 0.017]])
    rings = [polygon(9, math.sin(math.pi * k / 7), math.cos(math.pi * k / 7)) for k in range(6, 0, -1)]
    pebble, pebble_faces = stack(*rings)
    brick, brick_faces = stack(rectangle(0.025, 0.02, 0.0), rectangle(0.025, 0.02, 0.035))
    # The corner between the legs of the L comes first: from it all others are seen.
    ell = [(0.03, 0.03), (0.03, 0.06), (0.0, 0.06), (0.0, 0.0), (0.06, 0.0), (0.06, 0.03)]
    return {
        "cuboid": stack(rectangle(0.02, 0.03, 0.0), rectangle(0.02, 0.03, 0.03)),
        "bar": stack(rectangle(0.05, 0.015, 0.0), rectangle(0.05, 0.015, 0.03)),
        "drum": stack(polygon(32, 0.025, 0.0), polygon(32, 0.025, 0.04)),
        "wedge": stack(rectangle(0.03, 0.02, 0.0), rectangle(0.001, 0.02, 0.03)),
        "frustum": stack(polygon(5, 0.035, 0.0), polygon(5, 0.02, 0.03)),
        "ell": stack([(x, y, 0.0) for x, y in ell], [(x, y, 0.03) for x, y in ell]),
        # A box whose corners are off by up to 0.4 mm, as in scanned blocks.
        "brick": (brick + 4e-4 * np.sin(np.arange(24.0)).reshape(8, 3), brick_faces),
        "pebble": (pebble @ skew, pebble_faces),
    }


def write(path: Path, points: Array, faces: Array) -> None:
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


ROCKING = "frustum"
"""MuJoCo finds four contacts for its five corners, which change from step to step: it rocks by 3 um, awake."""


class Table:
    """A scene in which blocks are dropped, and one client."""

    def __init__(self, scene: str | Path, folder: Path) -> None:
        self.blocks = blocks()
        for name, (points, faces) in self.blocks.items():
            write(folder / f"{name}.obj", points, faces)
        self.world = RealWorld(scene, workspace=folder)
        add_command_server(self.world.parts)
        self.client = self.world.client()
        self.can_sleep = bool(self.world.simulation.model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP)
        start_stepped(self.client)

    def drop(
        self, name: str, place: Sequence[float], euler: Sequence[float], block: str | None = None
    ) -> None:
        code, *_ = vrep.simxCallScriptFunction(
            self.client,
            COMMAND_SERVER,
            vrep.sim_scripttype_childscript,
            "importShape",
            [0, 0, 255, 0],
            [*place, *euler, 0.5, 0.5, 0.5],
            [f"{block or name}.obj", name],
            bytearray(),
            BLOCKING,
        )
        assert code == vrep.simx_return_ok, vrep.simxGetLastErrors(self.client, BLOCKING)

    def pose(self, name: str) -> tuple[Array, Array]:
        """Position and 3 x 3 rotation."""
        handle = handle_of(self.client, name)
        _, position = vrep.simxGetObjectPosition(self.client, handle, -1, BLOCKING)
        _, (x, y, z, w) = vrep.simxGetObjectQuaternion(self.client, handle, -1, BLOCKING)
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, np.array([w, x, y, z]))
        return np.array(position), rotation.reshape(3, 3)

    def lowest(self, name: str) -> float:
        """Height of the block's lowest corner; a mesh's frame is in the middle of it."""
        points = self.blocks[name][0]
        position, rotation = self.pose(name)
        return float(
            (rotation @ (points - (points.min(axis=0) + points.max(axis=0)) / 2).T)[2].min() + position[2]
        )

    def is_awake(self, name: str) -> bool:
        simulation = self.world.simulation
        body = simulation.scene.get(handle_of(self.client, name)).body
        return bool(simulation.data.tree_asleep[simulation.model.body_treeid[body]] < 0)

    def assert_still(self, names: Sequence[str]) -> None:
        """They do not move for 3 s, and sleep where the scene lets bodies sleep."""
        before = [self.pose(name) for name in names]
        step(self.client, 3.0)
        for name, (position, rotation) in zip(names, before, strict=True):
            now, turned = self.pose(name)
            assert now == pytest.approx(position, abs=1e-4), name
            assert turned == pytest.approx(rotation, abs=1e-3), name
            if name != ROCKING:
                assert self.is_awake(name) is not self.can_sleep, name


@pytest.fixture(params=["ur5_rg2_kinect", "plain"])
def table(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Table]:
    scene: str | Path = request.param
    if scene == "plain":
        scene = tmp_path / "plain.xml"
        scene.write_text(PLAIN, encoding="utf-8")
    opened = Table(scene, tmp_path)
    try:
        yield opened
    finally:
        opened.world.close()


def test_eight_dropped_blocks_lie_on_the_floor_stop_and_sleep(table: Table) -> None:
    for index, name in enumerate(table.blocks):
        x, y = PLACE[0] + 0.15 * (index % 4), PLACE[1] + 0.15 * (index // 4)
        # The drum lands on its face, which has more corners than MuJoCo finds contacts for.
        tilt = (0.1, 0.05, 0.0) if name == "drum" else (0.4 + index, 0.9 * index, 2.0 * index)
        table.drop(name, [x, y, 0.08], tilt)
    step(table.client, 3.0)
    table.assert_still(list(table.blocks))
    heights = {name: table.lowest(name) for name in table.blocks}
    assert heights == pytest.approx(dict.fromkeys(heights, 0.0), abs=LEAST_CONTACT)


def test_blocks_rest_on_blocks(table: Table) -> None:
    """Faces of meshes meet in several points, or a tower would rock."""
    names = []
    for index in range(4):
        names.append(f"floor{index}")
        table.drop(names[-1], [*PLACE, 0.016 + 0.0305 * index], [0.0, 0.0, 0.2 * index], "cuboid")
    step(table.client, 3.0)
    table.assert_still(names)
    for index, name in enumerate(names):
        assert table.pose(name)[0][2] == pytest.approx(0.015 + 0.03 * index, abs=(index + 1) * LEAST_CONTACT)


def test_dynamic_mesh_of_a_loaded_model_rests(table: Table, tmp_path: Path) -> None:
    points, faces = table.blocks["frustum"]
    text = f"""
    <mujoco model="thing">
      <asset><mesh name="thing" vertex="{" ".join(f"{v:.6f}" for v in points.ravel())}"
        face="{" ".join(str(v) for v in faces.ravel())}"/></asset>
      <worldbody><body name="thing" pos="{PLACE[0]} {PLACE[1]} 0.08" euler="40 70 0"><freejoint/>
        <geom name="thing" type="mesh" mesh="thing" mass="0.2"/></body></worldbody>
    </mujoco>"""
    (tmp_path / "thing.xml").write_text(text, encoding="utf-8")
    code, _ = vrep.simxLoadModel(table.client, "thing.xml", 0, BLOCKING)
    assert code == vrep.simx_return_ok
    step(table.client, 3.0)
    table.assert_still(["thing"])
    position, rotation = table.pose("thing")
    assert (points @ rotation.T + position)[:, 2].min() == pytest.approx(0.0, abs=LEAST_CONTACT)


@pytest.mark.parametrize(
    ("joint", "contact", "expected"),
    [
        ("<freejoint/>", "", 6),
        ("<freejoint/>", 'condim="4"', 4),
        ("<freejoint/>", 'friction="0.5 0.005 0.0001"', 3),
        ('<joint type="hinge"/>', "", 3),  # a link of a mechanism, perhaps a wheel
        ("", "", 3),
    ],
)
def test_only_loose_meshes_with_default_contacts_are_settled(joint: str, contact: str, expected: int) -> None:
    spec = mujoco.MjSpec.from_string(
        '<mujoco><asset><mesh name="m" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/></asset><worldbody>'
        f'<body>{joint}<geom name="g" type="mesh" mesh="m" {contact}/></body></worldbody></mujoco>'
    )
    settle_loose_meshes(spec)
    assert spec.geom("g").condim == expected


RESPONDABLE = vrep.sim_shapeintparam_respondable
LOOKS = """
<mujoco>
  <asset>
    <mesh name="block" vertex="-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 -1 1  1 -1 1  1 1 1  -1 1 1" scale=".1 .1 .1"/>
    <mesh name="sheet" inertia="shell" vertex="-1 -1 0  1 -1 0  1 1 0  -1 1 0" face="0 1 2 0 2 3"/>
  </asset>
  <worldbody>
    <geom type="plane" size="3 3 0.1"/>
    <body name="block" pos="0 0 0.1"><freejoint/>
      <geom name="block" type="mesh" mesh="block" contype="0" conaffinity="0"/></body>
    <body name="sheet" pos="2 0 1"><geom name="sheet" type="mesh" mesh="sheet" contype="0" conaffinity="0"/></body>
  </worldbody>
</mujoco>
"""


def contacts_of_block(world: World) -> int:
    world.run(2)
    return sum(world.sim.model.geom("block").id in contact.geom for contact in world.sim.data.contact)


def test_mesh_that_is_made_respondable_touches_the_floor_in_several_points() -> None:
    world = World(LOOKS)
    block = world.handle("block")
    assert contacts_of_block(world) == 0
    world.sim.stop()
    world.call("simxSetObjectIntParameter", block, RESPONDABLE, 1)
    assert contacts_of_block(world) >= 3
    world.call("simxSetObjectIntParameter", block, RESPONDABLE, 0)
    assert contacts_of_block(world) == 0
    world.call("simxSetObjectIntParameter", block, RESPONDABLE, 1)
    assert world.call("simxGetObjectIntParameter", block, RESPONDABLE) == 1


def test_flat_mesh_can_be_made_respondable() -> None:
    world = World(LOOKS)
    sheet = world.handle("sheet")
    world.call("simxSetObjectIntParameter", sheet, RESPONDABLE, 1)
    assert world.call("simxGetObjectIntParameter", sheet, RESPONDABLE) == 1
