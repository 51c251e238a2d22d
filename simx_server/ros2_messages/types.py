"""Message and service types: a name, a hash, and how values become bytes and return."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .decoding import Decoders
from .encoding import HEADER, WRONG_VALUE, Encoders, Write
from .filling import default_value, fill
from .layouts import Layout, Value


class MessageType:
    """One type of message.

    Attributes:
        name: such as `sensor_msgs/msg/JointState`.
        dds_name: the name in keys, such as `sensor_msgs::msg::dds_::JointState_`; of a request or response that of
            its service.
        layout: the fields.
    """

    def __init__(
        self, layout: Layout, hash_of: Callable[[], str], encoders: Encoders, decoders: Decoders
    ) -> None:
        self.name = layout.name
        self.dds_name = dds_name(layout.name)
        self.layout = layout
        self._hash_of = hash_of
        self._encoders = encoders
        self._decoders = decoders

    def __repr__(self) -> str:
        return f"<MessageType {self.name}>"

    @property
    def hash(self) -> str:
        """Return the hash in keys, such as `RIHS01_a13e…`; of a request or response that of its service."""
        return self._hash_of()

    @property
    def constants(self) -> Mapping[str, Value]:
        """Return the values that the definition names, such as `ULTRASOUND`."""
        return self.layout.constants

    @cached_property
    def _write(self) -> Write:
        return self._encoders.of(self.layout)

    def encode(self, value: Mapping[str, Any]) -> bytes:
        """Return the bytes of a message, with CDR's header of 4 bytes.

        Args:
            value: the fields; nested messages are mappings. Numbers of an array are a list, a NumPy array, or their
                packed bytes, little endian. Missing fields have their defaults, which takes longer. Use `fill` on
                values from outside: `encode` does not search for fields that the message does not have.

        Raises:
            MessageError: a value does not fit its field.
        """
        parts: list[Any] = [HEADER]
        try:
            self._write(value, parts.append, 0)
        except WRONG_VALUE:
            parts = [HEADER]
            self._write(fill(self.layout, value), parts.append, 0)
        return b"".join(parts)

    def decode(self, data: bytes | bytearray | memoryview) -> dict[str, Any]:
        """Return the fields of a message; arrays of numbers are NumPy arrays that view the data.

        Args:
            data: with CDR's header.

        Raises:
            MessageError: the bytes are not such a message, or are beyond a limit.
        """
        return self._decoders.decode(self.layout, data)

    def fill(self, value: Any) -> dict[str, Any]:
        """Return a message with all fields, each of its type; missing ones have their defaults.

        Raises:
            MessageError: a field is unknown, or its value does not fit.
        """
        return fill(self.layout, value)

    def default(self) -> dict[str, Any]:
        """Return a message in which each field has its default; arrays of numbers are lists."""
        return default_value(self.layout)


@dataclass(frozen=True, slots=True)
class ServiceType:
    """One type of service.

    Attributes:
        name: such as `std_srvs/srv/Trigger`.
        dds_name: such as `std_srvs::srv::dds_::Trigger_`.
    """

    name: str
    dds_name: str
    request: MessageType
    response: MessageType

    @property
    def hash(self) -> str:
        """Return the hash in keys, such as `RIHS01_eeff…`."""
        return self.response.hash


def dds_name(name: str) -> str:
    """Return the name of a type in keys: `std_msgs/msg/Bool` gives `std_msgs::msg::dds_::Bool_`."""
    package, kind, short = name.split("/")
    if kind != "msg":
        short = short.removesuffix("_Request").removesuffix("_Response")
    return f"{package}::{kind}::dds_::{short}_"
