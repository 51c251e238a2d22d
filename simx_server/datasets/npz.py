"""Write episodes as NumPy files: a folder with ``episode-000.npz``, ..., and ``dataset.json`` with all names."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from simx_server.outputs.packages import OutputError

from .episodes import Episode, Layout

IMAGE = "image."
"""In front of a camera's name."""


class NpzWriter:
    """Writes one dataset."""

    def __init__(self, folder: Path, task: str) -> None:
        """Make the folder. Raises OutputError: it has files, or cannot be made."""
        self._folder, self._task = new_folder(folder, "--npz"), task
        self._layout: Layout | None = None
        self._episodes: list[dict[str, Any]] = []

    def add(self, layout: Layout, episode: Episode) -> None:
        """Write an episode."""
        self._layout = layout
        name = f"episode-{len(self._episodes):03d}.npz"
        np.savez_compressed(
            self._folder / name,
            allow_pickle=False,
            time=episode.times,
            observation=episode.observations,
            action=episode.actions,
            **{IMAGE + camera: images for camera, images in episode.images.items()},
        )
        self._episodes.append({"file": name, "steps": len(episode.actions), "is_success": episode.is_success})

    def close(self) -> None:
        """Write the names."""
        layout = self._layout
        if layout is None:
            return
        content = {
            "task": self._task,
            "time_step": layout.time_step,
            "observation": layout.observations,
            "action": layout.actions,
            "cameras": layout.cameras,
            "episodes": self._episodes,
        }
        (self._folder / "dataset.json").write_text(json.dumps(content, indent=2), encoding="utf-8")


def new_folder(folder: Path, flag: str) -> Path:
    """Make a folder for a dataset. Raises OutputError: it has files, or cannot be made."""
    try:
        if folder.is_dir() and any(folder.iterdir()):
            raise OutputError(
                f"'{folder}' has files and is not written over; give another {flag}, or delete it"
            )
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"'{folder}' cannot be made: {error.strerror}; give {flag} another folder"
        ) from None
    return folder
