"""The folder of a bag, as `ros2 bag record` makes it: the MCAP file, and `metadata.yaml`."""

from __future__ import annotations

import json
from pathlib import Path

from simx_server.outputs.packages import OutputError

from .bag_file import BagWriter

VERSION = 5
"""Of the metadata: Humble writes it, and all later distributions read it."""

SUFFIX = ".mcap"


def file_of(path: Path) -> Path:
    """Return the file of a bag: the path if it names one, else that in a folder, which is made.

    Raises:
        OutputError: the folder cannot be made, or has something in it.
    """
    if path.suffix == SUFFIX:
        return path
    try:
        path.mkdir(exist_ok=True)
        if any(path.iterdir()):
            raise OutputError(f"'{path}' exists already and is not empty; give another folder, or delete it")
    except OSError as error:
        raise OutputError(f"the folder '{path}' cannot be made: {error.strerror}") from None
    return path / f"{path.name}_0{SUFFIX}"


def write_metadata(writer: BagWriter) -> None:
    """Write `metadata.yaml` beside the file of a bag that is closed. Raises OutputError."""
    path = writer.path.parent / "metadata.yaml"
    try:
        path.write_text(metadata(writer), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"'{path}' cannot be written: {error.strerror}") from None


def metadata(writer: BagWriter) -> str:
    """Return the metadata of a bag that is closed: JSON, which is YAML too."""
    times = {
        "duration": {"nanoseconds": writer.last - writer.first},
        "starting_time": {"nanoseconds_since_epoch": writer.first},
        "message_count": writer.written,
    }
    information = {
        "version": VERSION,
        "storage_identifier": "mcap",
        **times,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": name,
                    "type": kind,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": topic.qos_profiles,
                },
                "message_count": topic.count,
            }
            for (name, kind), topic in sorted(writer.topics.items())
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [writer.path.name],
        "files": [{"path": writer.path.name, **times}],
    }
    return json.dumps({"rosbag2_bagfile_information": information}, indent=2) + "\n"
