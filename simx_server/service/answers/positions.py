"""Streams of joint positions, which are read from a copy of the joints' numbers.

After a step nothing is computed for such a stream: the copy is made by one call. A position that a client in this
process does not read costs nothing more; those of another client are packed together.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from simx_client.protocol.codec import NumberPacker
from simx_client.protocol.messages import STATUS_OK
from simx_server.joints.joints import position_in
from simx_server.joints.machine import Position

from .streams import Shared, Streams, Value

if TYPE_CHECKING:
    from simx_server.joints import Joints

JOINT_POSITION = "simxGetJointPosition"

Place = tuple[int, Position]
"""The id of a stream, and where its position is in the copy."""


class Positions(NamedTuple):
    """Which streams of a client are read from a copy."""

    joints: Joints
    version: int
    places: Mapping[int, Place]
    """By the joint's handle."""

    ids: Container[int]
    """Of these streams."""

    others: Sequence[Shared]
    """The other streams: their parts that are shared with other clients."""

    values: Sequence[tuple[int, Value]]
    """The same with the ids of their streams."""

    heads: Sequence[bytes]
    """The packed starts of their answers."""

    packer: NumberPacker

    present: memoryview[float]
    """The joints' numbers themselves, as long as the positions hold."""

    def hold(self, joints: Joints) -> bool:
        """Return whether the joints are the same, and at the same places."""
        return self.joints is joints and self.version == joints.places_version

    def packed(self, numbers: memoryview[float], time_ms: int) -> bytes:
        """Return the positions in a copy as they travel: each as the answer of its stream."""
        found = [  # as `position_in`, without a call for each
            position_in(numbers, position) if position[2] else numbers[position[0]] + position[1]
            for _, position in self.places.values()
        ]
        return self.packer.pack(STATUS_OK, time_ms, found)


def find_positions(joints: Joints, streams: Streams) -> Positions:
    """Find the streams of a client that can be read from a copy: of joints whose place is known."""
    values = streams.shared_values()
    wanted = {
        share.question[1]: stream_id for stream_id, share in values if share.command.name == JOINT_POSITION
    }
    known = joints.known_places(wanted)
    places = {handle: (wanted[handle], position) for handle, position in known.items()}
    ids = {stream_id for stream_id, _ in places.values()}
    others = [(stream_id, share) for stream_id, share in values if stream_id not in ids]
    shares = [share for _, share in others]
    heads = [streams.shared[stream_id].head for stream_id, _ in others]
    packer = NumberPacker(stream_id for stream_id, _ in places.values())
    present = joints.present_positions()
    return Positions(joints, joints.places_version, places, ids, shares, others, heads, packer, present)
