"""V-REP's render modes of vision sensors, by number and by name."""

from __future__ import annotations

HANDLES = 2
"""Each pixel is a handle."""

RENDER_MODES = {
    0: "colours",
    1: "auxiliary",
    HANDLES: "handles",
    3: "pov_ray",
    5: "external",
    6: "external_window",
    7: "opengl3",
    8: "opengl3_window",
}
"""Modes other than 2 draw colours here. In V-REP, 1 drew the auxiliary colour channels of shapes, 3 was the ray tracer
POV-Ray, 5 and 6 the renderer of a plug-in, 7 and 8 a renderer with shadows; 6 and 8 had a window.
"""

MODE_OF = {name: mode for mode, name in RENDER_MODES.items()}
"""The number of each name."""
