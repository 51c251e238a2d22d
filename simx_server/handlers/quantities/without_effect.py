"""Quantities that have a meaning in V-REP and none here: objects keep what was set.

V-REP's window, its other renderers and the drawing of edges use them. Programs set them all the same, and read them
again; the log says once that they have no effect.
"""

from __future__ import annotations

from .quantity import kept

_FIRST = {
    "objfloatparam_size_factor": 1.0,
    "shapefloatparam_texture_scaling_x": 1.0,
    "shapefloatparam_texture_scaling_y": 1.0,
    "camerafloatparam_near_clipping": 0.05,
    "camerafloatparam_far_clipping": 100.0,
    "cameraintparam_trackedobject": -1,
}
"""First values other than 0."""

_NAMES = {
    "objintparam": """
        collection_self_collision_indicator child_role parent_role manipulation_permissions hierarchycolor
    """,
    "visionintparam": """
        rendering_attributes windowed_size_x windowed_size_y windowed_pos_x windowed_pos_y
        pov_focal_blur pov_blur_sampled
    """,
    "visionfloatparam": "pov_blur_distance pov_aperture",
    "shapeintparam": """
        culling wireframe edge_visibility edge_borders_hidden sleepmodestart kinematic respondablesuspendcnt
    """,
    "shapefloatparam": """
        texture_x texture_y texture_z texture_a texture_b texture_g shading_angle edge_angle
    """,
    "cameraintparam": """
        rendering_attributes pov_focal_blur pov_blur_samples remotecameramode
    """,
    "camerafloatparam": "pov_blur_distance pov_aperture",
    # By how much the two sides of a force sensor drift apart; here they are one body.
    "forcefloatparam": "error_x error_y error_z error_a error_b error_g error_pos error_angle",
    "graphintparam": "needs_refresh",
}

WITHOUT_EFFECT = (
    *(kept(name, first) for name, first in _FIRST.items()),
    *(
        kept(f"{prefix}_{name}", 0 if "int" in prefix else 0.0)
        for prefix, names in _NAMES.items()
        for name in names.split()
    ),
)
