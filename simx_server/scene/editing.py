"""Changing the tree of a scene, stopped or running: removing objects, giving them another parent.

An edit compiles a new model and carries the whole state over by name; handles stay. During a run the original is kept
and comes back at stop.

What a new parent means physically:
* a body without joints of its own (static or welded) is welded to the new parent's body;
* a free body (it falls, it is pushed) stays free: only the tree changes, as in V-REP, where a dynamic shape under
  another shape is no part of it. Under a **force sensor** it is welded (V-REP's rigid link: what a gripper script means
  by attaching to `..._attachPoint`), and let go again when it gets another parent;
* a link (body with hinges or slides), a joint, a camera, site or light moves in the tree with all below it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.simulation import Simulation


def set_parent(sim: Simulation, handle: int, parent: int, keep_in_place: bool) -> None:
    """Give an object another parent (-1: none). `keep_in_place` keeps the world pose, else the numbers of the local one.

    Raises UnknownHandle, CommandError (a loop).
    """
    raise NotImplementedError


def remove_object(sim: Simulation, handle: int) -> None:
    """Remove one object; its children move up to its parent and stay in place (V-REP's rule). Raises UnknownHandle."""
    raise NotImplementedError


def remove_model(sim: Simulation, handle: int) -> None:
    """Remove a whole tree. Raises UnknownHandle, CommandError when the object is no model base."""
    raise NotImplementedError


def remove_all(sim: Simulation) -> None:
    """Remove every object (`sim_handle_all`)."""
    raise NotImplementedError


def create_dummy(sim: Simulation, size: float) -> int:
    """Add a dummy of this diameter (m) at the world's origin; returns its handle."""
    raise NotImplementedError
