"""ROS 2's messages and services that the server knows: their layouts, hashes and CDR bytes.

`BY_NAME` and `SERVICES` hold the server's types as ROS 2 Iron and later have them, `BUILT_IN` those of all
distributions, `known_types` those with the user's packages.
"""

from __future__ import annotations

from .errors import MessageError
from .grammar import DefinitionError
from .known import BUILT_IN, BY_NAME, HUMBLE_HASH, SERVICES, KnownTypes, Types, known_types
from .own import read_packages
from .types import MessageType, ServiceType

__all__ = (
    "BUILT_IN",
    "BY_NAME",
    "HUMBLE_HASH",
    "SERVICES",
    "DefinitionError",
    "KnownTypes",
    "MessageError",
    "MessageType",
    "ServiceType",
    "Types",
    "known_types",
    "read_packages",
)
