"""The selected objects: in V-REP's window a person clicks on them; here clients and scripts set them."""

from __future__ import annotations

from simx_server.simulation.part import Part


class Selection(Part):
    """Handles of the selected objects."""

    def __init__(self) -> None:
        self.handles: list[int] = []

    def scene_changed(self) -> None:
        self.handles = []  # another scene may have the same handles
