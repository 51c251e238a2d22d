"""Completion of ``simx-server`` in shells. The client finds this module by the entry point ``simx.completion``."""

from __future__ import annotations

from simx_server.files.library import list_scenes
from simx_server.settings.settings import SETTINGS

from .cli import make_parser as make_parser

PROGRAM = "simx-server"


def words_of_settings() -> dict[str, tuple[str, ...]]:
    """Return by field the values that a setting can have, where these are words."""
    return {name: setting.words for name, setting in SETTINGS.items()}


def scenes() -> tuple[str, ...]:
    """Return the names of the shipped scenes."""
    return tuple(list_scenes())
