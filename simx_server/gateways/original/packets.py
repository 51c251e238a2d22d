"""Cut messages into packets and put packets together: six bytes in front of each say how many follow."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator

ORDER = 1
"""The first word of a packet, in the byte order of its sender."""

SWAPPED_ORDER = 0x0100
"""The same word from a client of the other byte order."""

HEAD = struct.Struct("<HHH")
"""Byte order, bytes of payload in this packet, packets of this message that follow."""

LARGEST_PACKET = 30_000
"""Bytes of a packet to a client, with its head: the most that the original allows. A client needs a buffer of the
number of packets times the first one's size, and counts packets with 15 bits."""

MOST_PACKETS = 0x8000
"""Packets of a message: the client reads the number of those that follow as a signed 16-bit number."""

LARGEST_MESSAGE = MOST_PACKETS * (LARGEST_PACKET - HEAD.size)
"""Bytes of a message to a client."""


class BadPeer(Exception):
    """The bytes are not those of a client of the original; the connection ends. The text says what they are."""


def read_message(receive: Callable[[int], bytes], largest: int) -> bytes:
    """Return the next message, put together from its packets.

    Args:
        receive: returns exactly this number of bytes, or raises.
        largest: most bytes of a message.

    Raises:
        BadPeer: the bytes are of another program, of a client with the other byte order, or too many.
    """
    size, left = _head(receive(HEAD.size))
    if not left:
        return receive(size)
    parts = [receive(size)]
    total = size
    while left:
        size, following = _head(receive(HEAD.size))
        if following != left - 1:
            raise BadPeer(f"{left} packets of its message were to follow, and then {following + 1}")
        total += size
        if total > largest:
            raise BadPeer(f"its message has more than {largest} bytes")
        left = following
        parts.append(receive(size))
    return b"".join(parts)


def _head(head: bytes) -> tuple[int, int]:
    order, size, left = HEAD.unpack(head)
    if order == SWAPPED_ORDER:
        raise BadPeer("it is a big-endian client, which is not supported")
    if order != ORDER:
        raise BadPeer(
            "it does not speak the protocol of the original (a client of this project uses another port: --port)"
        )
    if not size:
        raise BadPeer("it sent an empty packet")
    return size, left


def packets(message: bytes, largest: int = LARGEST_PACKET) -> Iterator[bytes]:
    """Yield the packets of a message; all but the last have the same size, as the client's buffer requires.

    Args:
        message: at most `LARGEST_MESSAGE` bytes.
        largest: bytes of a packet, with its head.
    """
    each = largest - HEAD.size
    count = max(1, -(-len(message) // each))
    for number in range(count):
        part = message[number * each : (number + 1) * each]
        yield HEAD.pack(ORDER, len(part), count - 1 - number) + part
