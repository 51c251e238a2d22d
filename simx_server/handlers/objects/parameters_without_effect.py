"""Numbered object parameters that have a meaning in V-REP and none here: they keep what was set.

V-REP's window, its other renderers and the drawing of edges use them. Programs set them all the same, and read them
again; the log says once that they have no effect.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simx_server.scene.objects import ObjectKind

COMMON: Mapping[int, tuple[str, float]] = MappingProxyType(
    {
        27: ("objintparam_collection_self_collision_indicator", 0),
        29: ("objintparam_child_role", 0),
        30: ("objintparam_parent_role", 0),
        31: ("objintparam_manipulation_permissions", 0),
        34: ("objfloatparam_size_factor", 1.0),
        38: ("objintparam_hierarchycolor", 0),
    }
)
"""Those of every object: name and first value by number."""

_VIEW = {
    1006: ("visionintparam_disabled_light_components", 0),
    1007: ("visionintparam_rendering_attributes", 0),
    1009: ("visionintparam_windowed_size_x", 0),
    1010: ("visionintparam_windowed_size_y", 0),
    1011: ("visionintparam_windowed_pos_x", 0),
    1012: ("visionintparam_windowed_pos_y", 0),
    1013: ("visionintparam_pov_focal_blur", 0),
    1014: ("visionfloatparam_pov_blur_distance", 0.0),
    1015: ("visionfloatparam_pov_aperture", 0.0),
    1016: ("visionintparam_pov_blur_sampled", 0),
}

_SHAPE = {
    **{3006 + index: (f"shapefloatparam_texture_{part}", 0.0) for index, part in enumerate("xyzabg")},
    3012: ("shapefloatparam_texture_scaling_x", 1.0),
    3013: ("shapefloatparam_texture_scaling_y", 1.0),
    3014: ("shapeintparam_culling", 0),
    3015: ("shapeintparam_wireframe", 0),
    3024: ("shapeintparam_edge_visibility", 0),
    3025: ("shapefloatparam_shading_angle", 0.0),
    3026: ("shapefloatparam_edge_angle", 0.0),
    3027: ("shapeintparam_edge_borders_hidden", 0),
    3029: ("shapeintparam_sleepmodestart", 0),
    3030: ("shapeintparam_kinematic", 0),
    3031: ("shapeintparam_respondablesuspendcnt", 0),
}

_LIGHT = {
    8001: ("lightfloatparam_spot_exponent", 0.0),
    8002: ("lightfloatparam_spot_cutoff", 0.0),
    8003: ("lightfloatparam_const_attenuation", 1.0),
    8004: ("lightfloatparam_lin_attenuation", 0.0),
    8005: ("lightfloatparam_quad_attenuation", 0.0),
}

_CAMERA = {
    9000: ("cameraintparam_disabled_light_components", 0),
    9003: ("cameraintparam_rendering_attributes", 0),
    9004: ("cameraintparam_pov_focal_blur", 0),
    9005: ("camerafloatparam_pov_blur_distance", 0.0),
    9006: ("camerafloatparam_pov_aperture", 0.0),
    9007: ("cameraintparam_pov_blur_samples", 0),
    9008: ("camerafloatparam_near_clipping", 0.05),
    9009: ("camerafloatparam_far_clipping", 100.0),
    9011: ("cameraintparam_trackedobject", -1),
    9012: ("cameraintparam_remotecameramode", 0),
}

_FORCE = {
    5000 + index: (f"forcefloatparam_error_{part}", 0.0)
    for index, part in enumerate(("x", "y", "z", "a", "b", "g", "pos", "angle"))
}
"""By how much the two sides of a force sensor drift apart; here they are one body."""

BY_KIND: Mapping[ObjectKind, Mapping[int, tuple[str, float]]] = MappingProxyType(
    {
        ObjectKind.VISION_SENSOR: _VIEW,
        ObjectKind.SHAPE: _SHAPE,
        ObjectKind.LIGHT: _LIGHT,
        ObjectKind.CAMERA: _CAMERA,
        ObjectKind.FORCE_SENSOR: _FORCE,
        ObjectKind.GRAPH: {10500: ("graphintparam_needs_refresh", 0)},
    }
)
"""Those of one kind of object."""
