"""Constants of later versions for objects, poses, buffers, parameters and messages, which the remote API never had."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_BUFFERS = (
    "uint8", "int8", "uint16", "int16", "uint32", "int32", "float", "double",
    "uint8rgb", "uint8bgr", "uint8rgba", "uint8argb", "base64", "split",
)  # fmt: skip

TOPIC_CONSTANTS: Mapping[str, int] = MappingProxyType(
    {
        "handle_world": -1,
        "handle_inverse": -14,
        "handleflag_wxyzquat": 0x1000000,
        "handleflag_wxyzquaternion": 0x400000,
        "handleflag_reljointbaseframe": 0x400000,
        "handleflag_abscoords": 0x800000,
        "handleflag_resetforce": 0x400000,
        "handleflag_resettorque": 0x800000,
        "handleflag_resetforcetorque": 0xC00000,
        "handleflag_rawvalue": 0x1000000,
        "handleflag_silenterror": 0x2000000,
        "object_sceneobject_type": 100,
        "objectspecialproperty_detectable": 0x1F0,
        "objintparam_visible": 36,
        "jointintparam_dynctrlmode": 2039,
        "dummyfloatparam_size": 10002,
        "floatparam_physicstimestep": 3,
        "intparam_program_full_version": 39,
        "stringparam_scene_path": 14,
        "stringparam_scene_name": 15,
        "stringparam_remoteapi_temp_file_dir": 16,
        "physics_bullet": 0,
        "physics_ode": 1,
        "physics_vortex": 2,
        "physics_newton": 3,
        "physics_mujoco": 4,
        "verbosity_default": 400,
        "verbosity_questions": 410,
        "verbosity_tracelua": 800,
        "verbosity_traceall": 900,
        "verbosity_undecorated": 0xF000,
        "verbosity_onlyterminal": 0x10000,
        "verbosity_once": 0x20000,
        "msgbox_type_info": 0,
        "msgbox_type_question": 1,
        "msgbox_type_warning": 2,
        "msgbox_type_critical": 3,
        "msgbox_buttons_ok": 0,
        "msgbox_buttons_yesno": 1,
        "msgbox_buttons_yesnocancel": 2,
        "msgbox_buttons_okcancel": 3,
        "msgbox_return_cancel": 0,
        "msgbox_return_no": 1,
        "msgbox_return_yes": 2,
        "msgbox_return_ok": 3,
        "msgbox_return_error": 4,
        "buffer_clamp": 256,
        **{f"buffer_{name}": number for number, name in enumerate(_BUFFERS)},
    }
)
"""Name without ``sim.`` to number."""
