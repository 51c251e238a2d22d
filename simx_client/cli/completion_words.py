"""Programs as shells complete them: flags, commands, and the words that are valid at a place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

FILE, FOLDER = "file", "folder"
"""Kinds of paths."""


class Value(NamedTuple):
    """Words that are valid at one position of a command line."""

    words: tuple[str, ...] = ()
    path: str = ""
    """FILE or FOLDER where a path is valid."""


class Flag(NamedTuple):
    """A flag in all its spellings."""

    spellings: tuple[str, ...]
    help: str
    value: Value | None
    """None: the flag takes no value."""


class Program(NamedTuple):
    """A program, or a command of it."""

    name: str
    flags: Sequence[Flag] = ()
    value: Value = Value()
    """Valid words without a dash."""

    commands: Mapping[str, tuple[str, Program]] = MappingProxyType({})
    """Name to help and flags."""
