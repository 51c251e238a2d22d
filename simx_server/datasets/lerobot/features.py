"""The features of a dataset: what ``meta/info.json`` declares, and the values of an episode for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..episodes import Episode, Layout

STATE, SURROUNDINGS, ACTION = "observation.state", "observation.environment_state", "action"
DONE, SUCCESS = "next.done", "next.success"
TIMESTAMP, FRAME, EPISODE, INDEX, TASK = "timestamp", "frame_index", "episode_index", "index", "task_index"

Features = dict[str, dict[str, Any]]


def video_key(camera: str) -> str:
    """Return the feature of a camera; a name of LeRobot has no slash."""
    return f"observation.images.{camera.replace('/', '_')}"


def features_of(layout: Layout, fps: int) -> Features:
    """Return all features, as ``info.json`` has them."""
    robot, others = _split(layout)
    numbers = {STATE: robot, SURROUNDINGS: others, ACTION: layout.actions}
    features: Features = {
        key: {"dtype": "float32", "shape": [len(names)], "names": list(names)}
        for key, names in numbers.items()
        if names
    }
    for camera, (width, height) in layout.cameras.items():
        features[video_key(camera)] = {
            "dtype": "video",
            "shape": [height, width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": height,
                "video.width": width,
                "video.codec": "h264",
                "video.pix_fmt": "yuv420p",
                "video.is_depth_map": False,
                "video.fps": fps,
                "video.channels": 3,
                "has_audio": False,
            },
        }
    features |= {key: _single("bool") for key in (DONE, SUCCESS)}
    features |= {TIMESTAMP: _single("float32")}
    return features | {key: _single("int64") for key in (FRAME, EPISODE, INDEX, TASK)}


def values_of(layout: Layout, episode: Episode, number: int, first: int, fps: int) -> dict[str, NDArray[Any]]:
    """Return a row for each frame, by feature; images are left out.

    Args:
        number: of the episode.
        first: frames of all episodes before.
        fps: frames per second.
    """
    count = len(episode.actions)
    is_of_robot = np.array(layout.is_of_robot, np.bool_)
    observed = episode.observations[:count].astype(np.float32)
    frames = np.arange(count, dtype=np.int64)
    is_last = frames == count - 1
    rows: dict[str, NDArray[Any]] = {
        STATE: observed[:, is_of_robot],
        SURROUNDINGS: observed[:, ~is_of_robot],
        ACTION: episode.actions.astype(np.float32),
        DONE: is_last,
        SUCCESS: is_last & bool(episode.is_success),
        TIMESTAMP: (frames / fps).astype(np.float32),
        FRAME: frames,
        EPISODE: np.full(count, number, np.int64),
        INDEX: frames + first,
        TASK: np.zeros(count, np.int64),
    }
    return {key: each for key, each in rows.items() if each.ndim == 1 or each.shape[1]}


def _split(layout: Layout) -> tuple[list[str], list[str]]:
    both = list(zip(layout.observations, layout.is_of_robot, strict=True))
    return [name for name, is_it in both if is_it], [name for name, is_it in both if not is_it]


def _single(dtype: str) -> dict[str, Any]:
    return {"dtype": dtype, "shape": [1], "names": None}
