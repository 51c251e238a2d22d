"""Write episodes as a dataset of Minari, by its own package.

Without cameras an observation is one vector; with them it is a dictionary of ``state`` and of an image for each camera.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from simx_server import __version__
from simx_server.outputs.packages import package

from .episodes import Episode, Layout
from .npz import new_folder

STATE = "state"
DATA = "data"
"""The folder within the dataset's, as `minari.load_dataset` expects it."""


class MinariWriter:
    """Writes one dataset."""

    def __init__(self, folder: Path, task: str) -> None:
        """Make the folder. Raises OutputError: it has files or cannot be made, or a package is missing."""
        self._minari = package("minari", "--minari", "minari")
        package("h5py", "--minari", "minari")
        self._storage_type = package("minari.dataset.minari_storage", "--minari", "minari").MinariStorage
        self._buffer_type = package("minari.data_collector", "--minari", "minari").EpisodeBuffer
        self._spaces = package("gymnasium", "--minari", "minari").spaces
        self._folder, self._task = new_folder(folder, "--minari"), task
        self._storage: Any = None
        self._count = 0

    def add(self, layout: Layout, episode: Episode) -> None:
        """Write an episode."""
        if self._storage is None:
            self._storage = self._begin(layout)
        steps = len(episode.actions)
        observations: Any = episode.observations
        if episode.images:
            observations = {STATE: episode.observations, **episode.images}
        is_last = np.arange(steps) == steps - 1
        reached = is_last & bool(episode.is_success)
        self._storage.update_episodes(
            [
                self._buffer_type(
                    id=self._count,
                    observations=observations,
                    actions=episode.actions,
                    rewards=reached.astype(np.float64),
                    terminations=reached,
                    truncations=is_last & ~reached,
                    infos={"is_success": np.append(False, reached)},
                )
            ]
        )
        self._count += 1

    def close(self) -> None:
        """Do nothing: each episode is complete."""

    def _begin(self, layout: Layout) -> Any:
        box = self._spaces.Box

        def numbers(names: tuple[str, ...]) -> Any:
            return box(-np.inf, np.inf, (len(names),), np.float64)

        observed = numbers(layout.observations)
        if layout.cameras:
            images = {
                name: box(0, 255, (height, width, 3), np.uint8)
                for name, (width, height) in layout.cameras.items()
            }
            observed = self._spaces.Dict({STATE: observed, **images})
        storage = self._storage_type.new(
            self._folder / DATA,
            observation_space=observed,
            action_space=numbers(layout.actions),
            jpeg_encoding=False,
        )
        storage.update_metadata(
            {
                "dataset_id": self._folder.name,
                "minari_version": self._minari.__version__,
                "algorithm_name": "demonstrations",
                "code_permalink": "None",
                "description": f"{self._task}; simx {__version__}; observation: {', '.join(layout.observations)}; "
                f"action: {', '.join(layout.actions)}",
            }
        )
        return storage
