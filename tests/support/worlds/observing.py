"""Tests that want to be told of a simulation's life."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from simx_server.simulation.part import Part
from simx_server.simulation.simulation import Simulation


def observe(sim: Simulation, **events: Callable[..., Any]) -> Part:
    """Attach a part that does this at events: ``observe(sim, run_stopped=lambda: ...)``."""
    assert all(hasattr(Part, name) for name in events), f"Part has not all of {list(events)}"
    part = type("Observer", (Part,), {name: staticmethod(event) for name, event in events.items()})()
    sim.parts.attach(part)
    return part
