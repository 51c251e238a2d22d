"""State logs read back."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

NEEDED = "needs the extra log"
pytest.importorskip("foxglove_schemas_protobuf", reason=NEEDED)
reader = pytest.importorskip("mcap.reader", reason=NEEDED)
exceptions = pytest.importorskip("mcap.exceptions", reason=NEEDED)

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory  # noqa: E402 - comes with the extra

Logged = dict[str, list[tuple[int, Any]]]


def read(path: Path) -> Logged:
    """Of a log that may be cut off; each message by the schema that is in the file."""
    classes: dict[int, Any] = {}
    found: Logged = defaultdict(list)
    with path.open("rb") as file:
        try:
            for schema, channel, message in reader.NonSeekingReader(file).iter_messages(log_time_order=False):
                assert (channel.message_encoding, schema.encoding) == ("protobuf", "protobuf")
                if schema.id not in classes:
                    pool = descriptor_pool.DescriptorPool()
                    for each in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
                        pool.Add(each)
                    classes[schema.id] = message_factory.GetMessageClass(
                        pool.FindMessageTypeByName(schema.name)
                    )
                found[channel.topic].append((message.log_time, classes[schema.id].FromString(message.data)))
        except exceptions.EndOfFile:
            pass
    return found
