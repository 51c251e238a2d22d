"""The detection example: labels are where the ball is, the network learns, and what it finds becomes a place."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from example_modules import import_from

import simx_client

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.gl]

FOLDER = Path(__file__).parents[2] / "examples" / "detect"
COUNT = 12
RADIUS = 0.05
example = partial(import_from, FOLDER)
needs_torch = pytest.mark.skipif(
    importlib.util.find_spec("torch") is None,
    reason="needs the extra detect: PyTorch is not installed",
)


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with pytest.MonkeyPatch.context() as patch, example("simulator", patch).simulator() as port:
        yield port


@pytest.fixture(scope="module")
def collected(port: int, tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A small set, and the shots it was made of."""
    folder = tmp_path_factory.mktemp("collected") / "set"
    shots: list[Any] = []
    with pytest.MonkeyPatch.context() as patch:
        collect = example("collect", patch)
        take = collect.Studio.take
        patch.setattr(collect.Studio, "take", lambda studio: shots.append(take(studio)) or shots[-1])
        collect.main(["--port", str(port), "--count", str(COUNT), "--folder", str(folder), "--seed", "4"])
    return SimpleNamespace(folder=folder, shots=shots)


def picture_in(file: Path) -> np.ndarray:
    """(height, width, 3) RGB."""
    stored = cv2.imread(str(file))
    assert stored is not None, file
    return np.asarray(stored)[..., ::-1]


def labels_of(folder: Path) -> dict[int, np.ndarray]:
    """By the picture's number: (things, 5)."""
    return {
        int(file.stem): np.array([line.split() for line in file.read_text().splitlines()], float).reshape(
            -1, 5
        )
        for file in folder.glob("labels/*/*.txt")
    }


def outline(ball: np.ndarray) -> np.ndarray:
    """Left, top, right, bottom edge of a sphere in a 640 x 480 picture 57 degrees wide, pixels.

    A plane through the eye that touches the sphere is at sin(angle) = radius / distance from its middle, the distance
    measured in the plane of the picture's axis and the viewing axis.
    """
    focal = 320 / np.tan(np.radians(57) / 2)
    edges = []
    for across, centre in ((-ball[0], 320), (-ball[1], 240)):
        middle, half = np.arctan2(across, ball[2]), np.arcsin(RADIUS / np.hypot(across, ball[2]))
        edges.append([centre + focal * np.tan(middle - half), centre + focal * np.tan(middle + half)])
    return np.array(edges).T.ravel()


def test_labels_are_where_geometry_has_the_ball(collected: SimpleNamespace) -> None:
    labels = labels_of(collected.folder)
    assert sorted(labels) == list(range(COUNT))
    whole = 0
    for number, shot in enumerate(collected.shots):
        if shot.ball[2] < 0 or (edges := outline(shot.ball))[2] < 0 or edges[0] > 640 or edges[1] > 480:
            assert not len(labels[number])
            continue
        cut = np.clip(edges, 0, (640, 480, 640, 480))
        covered = shot.mask.sum() / (np.pi / 4 * np.prod(edges[2:] - edges[:2]))
        if len(labels[number]) == 0:
            assert covered < 0.1
            continue
        ((kind, x, y, width, height),) = labels[number]
        found = np.array([x - width / 2, y - height / 2, x + width / 2, y + height / 2]) * (
            640,
            480,
            640,
            480,
        )
        assert kind == 0
        assert np.all((found - cut)[:2] > -2)
        assert np.all((found - cut)[2:] < 2)
        if covered > 0.97:  # nothing hides a part of it
            assert np.abs(found - edges).max() < 2
            whole += 1
    assert whole >= 4
    assert any(not len(rows) for rows in labels.values())


def test_the_set_lies_as_yolo_wants_it_and_has_a_preview(collected: SimpleNamespace) -> None:
    folder = collected.folder
    assert "train: images/train\nval: images/val" in (folder / "data.yaml").read_text()
    for split, count in (("train", 10), ("val", 2)):
        files = sorted((folder / "images" / split).glob("*.jpg"))
        assert len(files) == count
        assert [file.stem for file in files] == [
            file.stem for file in sorted((folder / "labels" / split).glob("*"))
        ]
        for file in files:
            taken = collected.shots[int(file.stem)].picture
            assert np.abs(picture_in(file).astype(int) - taken).mean() < 3
    assert picture_in(folder.parent / "preview.png").shape == (540, 960, 3)
    # Light and colours differ from picture to picture.
    assert len({shot.picture[shot.mask].tobytes() for shot in collected.shots if shot.mask.any()}) > 5


@needs_torch
def test_training_lowers_the_loss_until_learned_images_are_known(
    collected: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = example("train", monkeypatch)
    monkeypatch.setattr(train, "BATCH", 5)
    # The pictures as they are: fewer turns suffice.
    monkeypatch.setattr(train, "augmented", lambda batch, labels, _: (train.as_tensor(batch), labels))
    detector, losses, _ = train.train(collected.folder, 40, 1)
    assert losses[-1] < 0.2 * losses[0]
    taken, labels = train.pictures.load(collected.folder, "train", train.SIZE)
    assert train.evaluate(detector, taken, labels).map50 > 0.8
    weights = collected.folder.parent / "ball.pt"
    detector.save(weights)
    # Every sixth was held out.
    largest = max(
        (shot for place, shot in enumerate(collected.shots) if place % 6 != 5),
        key=lambda shot: shot.mask.sum(),
    )
    found = train.Detector.load(weights).detect(largest.picture, 0.5)
    assert sys.modules["detector"].overlaps(found[0], np.array([largest.box]))[0] > 0.6


@needs_torch
def test_labels_follow_their_images_when_these_are_turned_and_tinted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    train = example("train", monkeypatch)
    batch = np.zeros((16, 120, 160, 3), np.uint8)
    batch[:, 30:50, 20:40] = 200, 100, 50
    labels = [np.array([[30 / 160, 40 / 120, 20 / 160, 20 / 120]])] * 16
    tensor, things = train.augmented(batch, labels, np.random.default_rng(3))
    sides = set()
    for picture, ((x, y, width, height),) in zip(tensor.numpy(), things, strict=True):
        rows, columns = np.nonzero(picture.max(axis=0) > 0.2)
        assert (columns.min(), columns.max() + 1) == pytest.approx(
            (160 * (x - width / 2), 160 * (x + width / 2))
        )
        assert (rows.min(), rows.max() + 1) == pytest.approx((120 * (y - height / 2), 120 * (y + height / 2)))
        sides.add(x < 0.5)
    assert sides == {True, False}
    assert len({picture.tobytes() for picture in tensor.numpy()}) == 16


@needs_torch
def test_measures_count_hits_misses_and_false_alarms(monkeypatch: pytest.MonkeyPatch) -> None:
    measure = example("measures", monkeypatch).measure
    thing = np.array([[0.5, 0.5, 0.2, 0.2]])
    hit, off = [0.41, 0.4, 0.6, 0.6], [0.7, 0.7, 0.9, 0.9]
    found = [
        np.array([[*hit, 0.9], [*hit, 0.8]]),
        np.array([[*off, 0.7]]),
        np.empty((0, 5)),
        np.empty((0, 5)),
    ]
    result = measure(found, [thing, thing, thing, np.empty((0, 4))], 0.75)
    # Two are sure enough, the second of which is the first again; of three things one was found.
    assert (result.precision, result.recall) == (0.5, pytest.approx(1 / 3))
    assert result.map50 == pytest.approx(1 / 3)
    late = measure([np.array([[*off, 0.9], [*hit, 0.6]])], [thing], 0.5)
    assert (late.precision, late.recall, late.map50) == (0.5, 1.0, 0.5)


@needs_torch
def test_boxes_that_overlap_are_one_and_a_box_of_no_size_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    detector = example("detector", monkeypatch)
    output = detector.torch.full((1, 5, 15, 20), -9.0)
    output[0, :, 5, 5] = output[0, :, 5, 6] = detector.torch.tensor([4.0, 0.0, 0.0, 1.0, 1.0])
    output[0, 0, 5, 6] = 3.0  # the neighbour sees the same, but is less sure
    output[0, :, 10, 15] = detector.torch.tensor(
        [2.0, 90.0, 0.0, 0.0, 0.0]
    )  # far outside, where it is cut to nothing
    (found,) = detector.boxes_of(output, 0.5)
    assert found[:, 4] == pytest.approx(1 / (1 + np.exp([-4.0, -2.0])))
    size = 0.1 * np.e
    x, y = 5.5 / 20, 5.5 / 15
    assert found[0, :4] == pytest.approx([x - size / 2, y - size / 2, x + size / 2, y + size / 2], abs=1e-6)
    assert found[1, 0] == found[1, 2] == 1.0


class ByColour:
    """A detector that needs no training: the ball is what is cyan."""

    def detect(self, picture: np.ndarray, threshold: float) -> np.ndarray:
        red, green, blue = np.moveaxis(picture.astype(int), 2, 0)
        rows, columns = np.nonzero((green > 2 * red) & (blue > green))
        if len(rows) < 20:
            return np.empty((0, 5))
        return np.array([[columns.min(), rows.min(), columns.max() + 1, rows.max() + 1, 1.0]], float)


@needs_torch
def test_what_is_found_becomes_a_place_in_the_world(
    port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "vrep", simx_client)
    detect = example("detect", monkeypatch)
    robot = detect.Robot("127.0.0.1", port)
    try:
        tally = detect.watch(robot, ByColour(), 6, tmp_path / "live.png")
    finally:
        robot.close()
    assert (tally.in_sight, tally.found, tally.false_alarms) == (6, 6, 0)
    assert max(tally.pixels) < 3
    assert max(tally.metres) < 0.005
    assert "found in 6 of these, 0 false alarms; median error" in capsys.readouterr().out
    assert picture_in(tmp_path / "live.png").shape == (360, 960, 3)
    with pytest.raises(SystemExit, match=r"there is no .*nothing\.pt; train\.py writes it"):
        detect.main(["--weights", str(tmp_path / "nothing.pt")])
