"""Random properties by name: in a simulation, in worlds of worker processes, in environments."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import simx_client as v
from simx_client.calls.marshalling import Marshal
from simx_client.client import Client
from simx_client.client.worlds import Worlds
from simx_client.errors import CallsFailed, RemoteError
from simx_client.protocol.commands import ANSWERED
from simx_client.randomization import Choice, LogUniform, Normal, Randomize, Scale, Shift, Uniform

SCENE = """
<mujoco>
  <worldbody>
    <light name="lamp" pos="0 0 3"/>
    <camera name="eye" pos="0 -2 1"/>
    <geom name="floor" type="plane" size="2 2 .1"/>
    <body name="cube" pos="0 0 0.05"><freejoint/>
      <geom type="box" size=".05 .05 .05" mass="0.1" rgba="1 0 0 1"/>
    </body>
    <body name="door" pos="1 1 0.5"><joint name="hinge" axis="1 0 0"/>
      <geom type="box" size=".02 .2 .3" pos="0 .2 0" mass="1"/>
    </body>
  </worldbody>
</mujoco>
"""

EVERYTHING = Randomize(
    {
        "cube.mass": Uniform(0.05, 0.2),
        "floor.friction": LogUniform(0.2, 1.0),
        "eye.position": Shift(Normal((0, 0, 0), 0.1, -0.2, 0.2)),
        "cube.color": Uniform((0, 0, 0), (1, 1, 1)),
        "lamp.color": Choice((1, 1, 1), (1, 0, 0)),
        "cube.pose": (0.1, 0.2, 0.05, 0, 0, 0, 1),
        "eye.view_angle": Scale(Uniform(0.9, 1.1)),
        "hinge.damping": Uniform(0.1, 0.5),
    }
)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scenes") / "table.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def client(scene: Path) -> Iterator[Client]:
    with Client.embedded(scene, speed="max") as made:
        yield made


def numbers(client: Client, name: str) -> list[float]:
    owner, _, attribute = name.partition(".")
    with client.batch() as calls:
        found = calls.note(Marshal(ANSWERED["readNumbers"]), (client.object(owner).handle, attribute))
    return found.value


def test_every_property_gets_what_was_drawn(client: Client) -> None:
    (drawn,) = EVERYTHING.apply(client, seed=1)
    assert list(drawn) == list(EVERYTHING.values)
    for name, values in drawn.items():
        assert numbers(client, name) == pytest.approx(values, abs=1e-6)
    assert 0.05 <= drawn["cube.mass"][0] <= 0.2


def test_equal_seeds_draw_equal_numbers_and_others_do_not(client: Client) -> None:
    fixed = Randomize({"cube.mass": Uniform(0.05, 0.2), "cube.color": Uniform((0, 0, 0), (1, 1, 1))})
    assert fixed.apply(client, 3) == fixed.apply(client, 3)
    assert fixed.apply(client, 3) != fixed.apply(client, 4)


def test_the_scenes_own_values_are_read_once(client: Client) -> None:
    drawing = Randomize({"cube.mass": Scale(Uniform(0.5, 2)), "cube.position": Shift((0.1, 0, 0))}).on(client)
    first = drawing.set_by_seed(3)
    assert drawing.set_by_seed(4) != first
    assert drawing.set_by_seed(3) == first
    assert numbers(client, "cube.mass") == pytest.approx(first[0]["cube.mass"])


def test_the_stop_restores_what_was_set_while_a_run_lasted(client: Client) -> None:
    before = numbers(client, "cube.mass"), numbers(client, "floor.friction")
    client.simulation.start()
    Randomize({"cube.mass": 0.7, "floor.friction": 0.123}).apply(client, 1)
    assert numbers(client, "cube.mass") == pytest.approx([0.7])
    client.simulation.stop()
    assert (numbers(client, "cube.mass"), numbers(client, "floor.friction")) == before


def test_the_damping_of_a_joint_brakes_it_and_outlives_edits(scene: Path) -> None:
    fallen = []
    for damping in (0.0, 2.0):
        with Client.embedded(scene) as client:
            Randomize({"hinge.damping": damping}).apply(client, 1)
            copied = v.simxCopyPasteObjects(client.id, [client.object("cube").handle], v.simx_opmode_blocking)
            assert copied[0] == v.simx_return_ok  # this compiles a new model
            assert numbers(client, "hinge.damping") == [damping]
            with client.stepping() as step:
                for _ in range(5):
                    step()
                fallen.append(abs(client.joint("hinge").position))
            with pytest.raises(CallsFailed, match="must not be below 0"):
                Randomize({"hinge.damping": -1.0}).apply(client, 1)
    assert fallen[0] > 2 * fallen[1] > 0


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("cube.weight", "valid: "),
        ("cube.masss", "did you mean 'mass'"),
        ("cub.mass", "cube"),
        ("eye.mass", "view_angle"),
    ],
)
def test_an_unknown_name_is_refused_with_the_valid_ones(client: Client, name: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Randomize({name: 1.0}).apply(client, 1)


def test_a_value_of_another_length_is_refused(client: Client) -> None:
    with pytest.raises(ValueError, match=r"'cube.color' has 3 numbers, and Uniform\(low=0, high=1\) gives 1"):
        Randomize({"cube.color": Uniform(0, 1)}).apply(client, 1)


def test_a_server_refuses_numbers_that_are_none(client: Client) -> None:
    handle = client.object("cube").handle
    for attribute, values, why in (
        ("position", [float("nan"), 0.0, 0.0], "number"),
        ("quaternion", [0.0, 0.0, 0.0, 0.0], "no rotation"),
        ("mass", [1.0, 2.0], "1 numbers, not 2"),
        ("absPosition", [], "3 numbers, not 0"),
    ):
        with pytest.raises(RemoteError, match=why), client.batch() as calls:
            calls.note(Marshal(ANSWERED["writeNumbers"]), (handle, attribute, values))


@pytest.mark.parametrize("name", ["cube", ".mass", "cube.", ""])
def test_a_name_without_an_object_or_a_property_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"write OBJECT\.PROPERTY"):
        Randomize({name: 1.0})


@pytest.mark.parametrize(
    "make",
    [
        lambda: Uniform(2, 1),
        lambda: LogUniform(0, 1),
        lambda: Normal(0, -1),
        lambda: Choice(),
        lambda: Choice(1.0, (1.0, 2.0)),
        lambda: Choice("red", "blue"),  # pyright: ignore[reportArgumentType]
        lambda: Choice(1.0, float("inf")),
        lambda: Uniform("low", 1),  # pyright: ignore[reportArgumentType]
        lambda: Uniform((0, 0), (1, 1, 1)),
        lambda: Normal((0, 0), (1, 1, 1)),
        lambda: Normal(0, 1, low=float("nan")),
        lambda: Normal(0, 1, 3, 2),
        lambda: Randomize({"cube.mass": float("nan")}),
        lambda: Randomize({"cube.mass": "heavy"}),  # pyright: ignore[reportArgumentType]
    ],
)
def test_ranges_that_cannot_be_drawn_from_are_refused(make) -> None:
    with pytest.raises(ValueError, match=r"needs|valid"):
        make()


def test_distributions_stay_in_their_ranges() -> None:
    random = np.random.default_rng(0)
    for _ in range(200):
        assert 0.1 <= LogUniform(0.1, 10).draw(random) <= 10
        assert -1 <= Normal(0, 5, -1, 1).draw(random) <= 1
        assert Choice(1, 2).draw(random) in (1, 2)


def test_worlds_in_a_worker_process_get_the_numbers_of_their_seeds(scene: Path) -> None:
    random = Randomize({"cube.mass": Uniform(0.05, 0.2)})
    with Worlds(scene, 2, processes=1) as worlds:
        drawn = random.apply(worlds, 5)
    with Client.embedded(scene) as client:
        assert random.apply(client, 6) == drawn[1:]
    assert drawn[0] != drawn[1]


def test_episodes_of_one_seed_are_equal_whatever_came_before(scene: Path) -> None:
    gym = pytest.importorskip("simx_client.gym")
    # Of two shapes that touch, the larger friction counts.
    random = Randomize(
        {"cube.mass": Uniform(0.05, 0.5), "cube.friction": Uniform(0.01, 1), "floor.friction": 0.01}
    )
    environment = gym.SimxEnv(
        scene,
        observations=["cube.position"],
        actions={"x.float_signal": (-1, 1)},
        start={"cube.euler_angles": (0.5, 0.3, 0.2), "cube.position": (0, 0, 0.3)},
        reward=lambda now: 0.0,
        randomize=random,
    )

    def episode(seed: int | None) -> bytes:
        seen = [environment.reset(seed=seed)[0]]
        seen += [environment.step([0.0])[0] for _ in range(15)]
        return np.stack(seen).tobytes()

    first, other = episode(1), episode(None)
    assert first != other
    assert episode(1) == first
    environment.close()
    vector = gym.SimxVectorEnv(environment.task, 2, processes=0)
    vector.reset(seed=0)
    seen = [vector.reset(seed=0)[0][1], *(vector.step(np.zeros((2, 1)))[0][1] for _ in range(15))]
    assert np.stack(seen).tobytes() == first  # world 1 of seed 0 is seed 1
    vector.close()
