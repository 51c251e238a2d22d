"""Worlds that are saved and loaded again."""

from __future__ import annotations

from pathlib import Path

from handler_calls import QuickPainter, World

from simx_server.editing.saving.packing import pack_scene


def reloaded(world: World, folder: Path, name: str = "saved.ttt") -> World:
    """Return another world with the scene of this one, which was saved into the folder."""
    file = folder / name
    file.write_bytes(pack_scene(world.parts).data)
    found = World(file=file, workspace=folder, painter=QuickPainter())
    _opened.append(found)
    return found


def opened(world: World) -> World:
    """Return a world whose scripts `close_worlds` ends."""
    _opened.append(world)
    return world


def close_worlds() -> None:
    """End the scripts of all worlds so far: those in Python have processes."""
    while _opened:
        _opened.pop().parts.scripts.close()


_opened: list[World] = []
