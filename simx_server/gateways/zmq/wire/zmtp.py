"""ZeroMQ's protocol on one connection, as a server without passwords speaks it: ZMTP 3.1 with the mechanism NULL.

`RFC 37 <https://rfc.zeromq.org/spec/37/>`_ describes it: a greeting, a command READY from both sides, then frames. The
server does not use ZeroMQ's library, whose separate thread reads and sends: to wake it twice costs as much as the rest
of a call. Nothing here knows a socket.
"""

from __future__ import annotations

from collections.abc import Iterator

_MORE, _LONG, _COMMAND = 1, 2, 4
"""Bits of a frame's first byte: another frame follows, the length has eight bytes, it is a command."""

_USUAL = b"\x01\x00\x00"
"""How almost every message starts: an empty frame, and behind it the last one, of less than 256 bytes."""

_READY, _ERROR, _PING, _PONG = b"\x05READY", b"\x05ERROR", b"\x04PING", b"\x04PONG"
_KIND = b"socket-type"
_PARTNERS = (b"REQ", b"DEALER", b"ROUTER")
"""Kinds of sockets that talk with a ROUTER."""

LONGEST_COMMAND = 4096
"""Bytes of a command; those of libraries have less than 100."""

MOST_AT_ONCE = 64
"""Frames that are read together; a correct client sends two and waits for the answer."""

_LONGEST_CONTEXT = 16
"""Bytes of a PING that are sent back."""


class BadPeer(Exception):
    """The peer breaks the rules, or does not speak this protocol; the text says how."""


def framed(payload: bytes) -> bytes:
    """Return a message as it travels to a client: behind an empty frame."""
    size = len(payload)
    head = b"\x01\x00\x00%c" % size if size < 256 else b"\x01\x00\x02" + size.to_bytes(8, "big")
    return head + payload


def framed_alone(payload: bytes) -> bytes:
    """Return a message as it travels to a client of API 2: one frame."""
    size = len(payload)
    head = b"\x00%c" % size if size < 256 else b"\x02" + size.to_bytes(8, "big")
    return head + payload


def _command(body: bytes) -> bytes:
    return bytes((_COMMAND, len(body))) + body


GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x01" + b"NULL".ljust(20, b"\0") + bytes(32)
"""Signature, version, mechanism, no server of the mechanism, nothing; the first that is sent to a peer."""

_SIGNATURE_END, _VERSION, _MINOR, _MECHANISM = 9, 10, 11, slice(12, 32)
"""Places in a greeting."""

PING = _command(_PING + bytes(2))
"""Asks a peer for a PONG; the two bytes are a time that means nothing here."""

READY = _command(_READY + b"\x0bSocket-Type\x00\x00\x00\x06ROUTER")
"""Sent when the peer's greeting is here."""


class Incoming:
    """Reads what one peer sends."""

    def __init__(self, longest: int) -> None:
        """Read from the first byte of a connection.

        Args:
            longest: bytes that a message may have.
        """
        self._longest = longest
        self._data = bytearray()
        """Bytes that are not read yet."""

        self._is_greeted = False
        self.is_ready = False
        """The peer has said everything that comes before its messages."""

        self.answers_pings = False
        """The peer's version has PING: a library answers it, also while its program computes."""

        self._is_inside = False
        """The next frame is behind an empty one."""

        self.is_alone = False
        """The newest message came without an empty frame, as those of API 2 do."""

        self.missing = 0
        """Bytes at least of a long frame that are still to come."""

        self.due = b""
        """Bytes to send to the peer now; the sender clears it."""

    @property
    def held(self) -> int:
        """Return how many bytes of a message that is not complete are kept."""
        return len(self._data)

    def take(self, data: bytes) -> list[bytes]:
        """Return the messages that are complete with these further bytes.

        Raises:
            BadPeer: the connection cannot be used any longer.
        """
        is_start = self.is_ready and not self._data and not self._is_inside
        if is_start and data.startswith(_USUAL) and len(data) > 3 and len(data) == 4 + data[3]:
            self.is_alone = False
            return [data[4:]]
        self._data += data
        self.missing = 0
        if not self._is_greeted and not self._greet():
            return []
        return list(self._messages())

    def _greet(self) -> bool:
        """Read the peer's greeting; return whether it is complete."""
        start = self._data
        if start[0] != 0xFF or not (len(start) <= _SIGNATURE_END or start[_SIGNATURE_END] & 1):
            raise BadPeer("the peer does not speak ZeroMQ's protocol")
        if len(start) > _VERSION and start[_VERSION] < 3:
            raise BadPeer(
                "the peer speaks a version of ZeroMQ's protocol before 3; libraries since 2013 speak 3"
            )
        if len(start) < len(GREETING):
            return False
        mechanism = bytes(start[_MECHANISM]).rstrip(b"\0")
        if mechanism != b"NULL":
            raise BadPeer(
                f"the peer asks for {mechanism.decode('ascii', 'replace')}, and the server has NULL only"
            )
        self.answers_pings = start[_VERSION] > 3 or start[_MINOR] >= 1
        del start[: len(GREETING)]
        self._is_greeted, self.due = True, READY
        return True

    def _messages(self) -> Iterator[bytes]:
        """Read the complete frames."""
        for _ in range(MOST_AT_ONCE):
            frame = self._frame()
            if frame is None:
                return
            flags, body = frame
            if flags & _COMMAND:
                self._obey(body)
            elif not self.is_ready:
                raise BadPeer("the peer sends a message before READY")
            elif self._is_inside or (not flags & _MORE and body):
                if flags & _MORE:
                    raise BadPeer("a message has other frames than a client's")
                self.is_alone, self._is_inside = not self._is_inside, False
                yield body
            elif body or not flags & _MORE:
                raise BadPeer("a message has other frames than a client's")
            else:
                self._is_inside = True
        raise BadPeer("a client sends on without reading answers")

    def _frame(self) -> tuple[int, bytes] | None:
        """Return the flags and the content of the next frame; None if it is not complete."""
        data = self._data
        if len(data) < 2:
            return None
        flags, size, start = data[0], data[1], 2
        if flags & _LONG:
            if len(data) < 9:
                return None
            size, start = int.from_bytes(data[1:9], "big"), 9
        longest = LONGEST_COMMAND if flags & _COMMAND else self._longest
        if size > longest:
            raise BadPeer(f"the peer sends {size} bytes at a time, and at most {longest} are read")
        end = start + size
        if len(data) < end:
            self.missing = end - len(data)
            return None
        with memoryview(data) as view:
            body = bytes(view[start:end])
        del data[:end]
        return flags, body

    def _obey(self, body: bytes) -> None:
        """Act on a command; unknown ones have no meaning for a server."""
        if not self.is_ready:
            self._check_ready(body)
            self.is_ready = True
        elif body.startswith(_PING):  # behind it is a time in two bytes
            start = len(_PING) + 2
            self.due += _command(_PONG + body[start : start + _LONGEST_CONTEXT])

    def _check_ready(self, body: bytes) -> None:
        if body.startswith(_ERROR):
            raise BadPeer(f"the peer refuses the server: {body[7:100].decode('ascii', 'replace')}")
        kind = dict(_properties(body.removeprefix(_READY))).get(_KIND) if body.startswith(_READY) else None
        if kind not in _PARTNERS:
            raise BadPeer("the peer is no socket of kind REQ or DEALER, as clients have")


def _properties(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Return the names, in small letters, and values in a READY; what is cut off has no value."""
    place = 0
    while place < len(data):
        value = place + 1 + data[place]
        start = value + 4
        end = start + int.from_bytes(data[value:start], "big")
        yield data[place + 1 : value].lower(), data[start:end]
        place = end
