"""A set of labelled pictures in the layout of YOLO, and pictures with boxes drawn in them.

FOLDER/data.yaml                 where the pictures are, and the names of the classes
FOLDER/images/train/000001.jpg   and images/val/...
FOLDER/labels/train/000001.txt   one line for each thing: class, x and y of the middle, width, height; 0..1
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

CameraImage = NDArray[np.uint8]
"""(height, width, 3) RGB, the top row first."""
Box = Sequence[float]
"""Left, top, right and bottom edge, pixels."""

SPLITS = ("train", "val")
TRUTH, FOUND = (255, 255, 255), (255, 230, 0)
"""Colours of boxes, RGB."""

DATA = """\
path: .
train: images/train
val: images/val
names:
  0: ball
"""


def begin(folder: Path) -> None:
    """Make the folders of an empty set. What an earlier set left in them goes."""
    for split in SPLITS:
        for kind, suffix in (("images", "jpg"), ("labels", "txt")):
            (folder / kind / split).mkdir(parents=True, exist_ok=True)
            for old in (folder / kind / split).glob(f"??????.{suffix}"):
                old.unlink()
    (folder / "data.yaml").write_text(DATA)


def save(folder: Path, split: str, number: int, picture: CameraImage, boxes: Iterable[Box]) -> None:
    """Add a picture and its labels. Raises OSError."""
    height, width = picture.shape[:2]
    lines = [
        f"0 {(left + right) / 2 / width:.6f} {(top + bottom) / 2 / height:.6f} "
        f"{(right - left) / width:.6f} {(bottom - top) / height:.6f}\n"
        for left, top, right, bottom in boxes
    ]
    (folder / "labels" / split / f"{number:06}.txt").write_text("".join(lines))
    write(folder / "images" / split / f"{number:06}.jpg", picture)


def load(folder: Path, split: str, size: tuple[int, int]) -> tuple[CameraImage, list[NDArray[np.float64]]]:
    """All pictures of a split, made smaller, and their labels.

    Args:
        size: width and height to give them.

    Returns:
        (n, height, width, 3), and for each picture (things, 4): x, y of the middle, width, height; 0..1.

    Raises:
        FileNotFoundError: there are none. OSError: one cannot be read.
    """
    files = sorted((folder / "images" / split).glob("*.jpg"))
    if not files:
        raise FileNotFoundError(f"no pictures in {folder / 'images' / split}; make some with collect.py")
    pictures = np.empty((len(files), size[1], size[0], 3), np.uint8)
    labels = []
    for place, file in enumerate(files):
        stored = cv2.imread(str(file))
        if stored is None:
            raise OSError(f"{file} cannot be read as a picture")
        pictures[place] = shrunk(np.asarray(cv2.cvtColor(stored, cv2.COLOR_BGR2RGB), np.uint8), size)
        rows = (folder / "labels" / split / f"{file.stem}.txt").read_text().split("\n")
        labels.append(np.array([row.split()[1:] for row in rows if row], float).reshape(-1, 4))
    return pictures, labels


def shrunk(picture: CameraImage, size: tuple[int, int]) -> CameraImage:
    """Of this width and height; each pixel the mean of those it stands for."""
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def with_boxes(
    picture: CameraImage, boxes: Iterable[Box], colour: tuple[int, int, int] = TRUTH
) -> CameraImage:
    """A copy with frames around the boxes."""
    drawn = picture.copy()
    for box in boxes:
        left, top, right, bottom = (round(edge) for edge in box)
        cv2.rectangle(drawn, (left - 2, top - 2), (right + 1, bottom + 1), colour, 2)
    return drawn


def sheet(pictures: Sequence[CameraImage], columns: int = 4, width: int = 240) -> CameraImage:
    """Many pictures on one, each `width` pixels wide, row by row."""
    small = [shrunk(picture, (width, width * picture.shape[0] // picture.shape[1])) for picture in pictures]
    small += [np.zeros_like(small[0])] * (-len(small) % columns)
    return np.vstack([np.hstack(small[first : first + columns]) for first in range(0, len(small), columns)])


def write(path: Path, picture: CameraImage) -> None:
    """Write a PNG or JPEG. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(path), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)):
        raise OSError(f"the picture could not be written to {path}")
