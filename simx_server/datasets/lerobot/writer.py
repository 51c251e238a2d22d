"""Write a dataset of LeRobot: files, and the tables that describe them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from simx_server.errors import CommandError
from simx_server.outputs.packages import package

from ..episodes import Episode, Layout
from ..npz import new_folder
from .features import features_of, values_of, video_key
from .film import write_film
from .statistics import Statistics, as_lists, merged, of_images, of_numbers

VERSION = "v3.0"
_FILES = 1000
"""Most files of a folder."""

_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA, _EPISODES, _VIDEO = (
    f"data/{_FILE}.parquet",
    f"meta/episodes/{_FILE}.parquet",
    f"videos/{{video_key}}/{_FILE}.mp4",
)
_INDEX_NAME = "__index_level_0__"
"""The column that pandas takes as the index of a table: the table of tasks is read by pandas."""


class LeRobotWriter:
    """Writes one dataset. All rows are in one file, and each film is one episode of one camera."""

    def __init__(self, folder: Path, task: str) -> None:
        """Make the folder. Raises OutputError: it has files or cannot be made, or a package is missing."""
        self._parquet = package("pyarrow.parquet", "--lerobot", "datasets")
        self._arrow = package("pyarrow", "--lerobot", "datasets")
        self._av = package("av", "--lerobot", "datasets")
        self._folder, self._task = new_folder(folder, "--lerobot"), task
        self._layout: Layout | None = None
        self._rows: Any = None
        self._episodes: list[dict[str, Any]] = []
        self._statistics: list[dict[str, Statistics]] = []
        self._frames = 0

    def add(self, layout: Layout, episode: Episode) -> None:
        """Write an episode. Raises CommandError: the format cannot have it."""
        self._layout, number, count = layout, len(self._episodes), len(episode.actions)
        fps = _fps(layout)
        values = values_of(layout, episode, number, self._frames, fps)
        statistics = {key: of_numbers(rows) for key, rows in values.items()}
        entry: dict[str, Any] = {
            "episode_index": number,
            "tasks": [self._task],
            "length": count,
            "data/chunk_index": 0,
            "data/file_index": 0,
            "dataset_from_index": self._frames,
            "dataset_to_index": self._frames + count,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        chunk, file = divmod(number, _FILES)
        for camera, images in episode.images.items():
            key = video_key(camera)
            place = _VIDEO.format(video_key=key, chunk_index=chunk, file_index=file)
            write_film(self._av, self._folder / place, images[:count], fps)
            statistics[key] = of_images(images[:count])
            entry |= {f"videos/{key}/chunk_index": chunk, f"videos/{key}/file_index": file}
            entry |= {f"videos/{key}/from_timestamp": 0.0, f"videos/{key}/to_timestamp": count / fps}
        entry |= {
            f"stats/{key}/{name}": each
            for key, some in statistics.items()
            for name, each in as_lists(some).items()
        }
        self._write_rows(values)
        self._episodes.append(entry)
        self._statistics.append(statistics)
        self._frames += count

    def close(self) -> None:
        """Write the tables of episodes and tasks, the statistics, and what the dataset has."""
        layout = self._layout
        if layout is None or self._rows is None:
            return
        self._rows.close()
        self._write_table(self._arrow.Table.from_pylist(self._episodes), _EPISODES)
        self._write_tasks()
        fps, count = _fps(layout), len(self._episodes)
        self._write_json(
            "stats.json",
            {key: as_lists(merged([each[key] for each in self._statistics])) for key in self._statistics[0]},
        )
        self._write_json(
            "info.json",
            {
                "codebase_version": VERSION,
                "robot_type": None,
                "total_episodes": count,
                "total_frames": self._frames,
                "total_tasks": 1,
                "chunks_size": _FILES,
                "data_files_size_in_mb": 100,
                "video_files_size_in_mb": 200,
                "fps": fps,
                "splits": {"train": f"0:{count}"},
                "data_path": _DATA,
                "video_path": _VIDEO if layout.cameras else None,
                "features": features_of(layout, fps),
            },
        )

    def _write_rows(self, values: dict[str, Any]) -> None:
        arrow = self._arrow
        columns = {
            key: arrow.array(rows)
            if rows.ndim == 1
            else arrow.FixedSizeListArray.from_arrays(arrow.array(rows.reshape(-1)), rows.shape[1])
            if rows.shape[1] > 1
            else arrow.array(rows[:, 0])
            for key, rows in values.items()
        }
        table = arrow.table(columns)
        if self._rows is None:
            self._rows = self._parquet.ParquetWriter(self._placed(_DATA), table.schema)
        self._rows.write_table(table)

    def _write_tasks(self) -> None:
        description = {
            "index_columns": [_INDEX_NAME],
            "column_indexes": [],
            "columns": [
                {
                    "name": name,
                    "field_name": field,
                    "pandas_type": kind,
                    "numpy_type": stored,
                    "metadata": None,
                }
                for name, field, kind, stored in (
                    ("task_index", "task_index", "int64", "int64"),
                    (None, _INDEX_NAME, "unicode", "object"),
                )
            ],
            "pandas_version": "2.0.0",
        }
        table = self._arrow.table({"task_index": [0], _INDEX_NAME: [self._task]})
        self._parquet.write_table(
            table.replace_schema_metadata({"pandas": json.dumps(description)}),
            self._folder / "meta" / "tasks.parquet",
        )

    def _write_table(self, table: Any, place: str) -> None:
        self._parquet.write_table(table, self._placed(place))

    def _write_json(self, name: str, content: Any) -> None:
        (self._folder / "meta" / name).write_text(json.dumps(content, indent=4), encoding="utf-8")

    def _placed(self, place: str) -> Path:
        """Return the first file of a kind; its folder is made."""
        path = self._folder / place.format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def _fps(layout: Layout) -> int:
    """Return the frames per second, one for each simulation step. Raises CommandError."""
    fps = round(1 / layout.time_step)
    if abs(fps * layout.time_step - 1) > 1e-9:
        raise CommandError(
            f"LeRobot counts whole frames per second, which steps of {layout.time_step:g} s do not give; record with "
            "--time-step 0.05, or export with --npz"
        )
    for name, (width, height) in layout.cameras.items():
        if width % 2 or height % 2:
            raise CommandError(
                f"films have even sides, not {width}x{height}; export {name}:{width + width % 2}x{height + height % 2}"
            )
    return fps
