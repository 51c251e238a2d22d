"""Numbers of parameters: of objects, of the simulator, of scripts."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .counting import counted

_OBJECTS = {
    "objintparam_collection_self_collision_indicator": 27,
    "objstringparam_dna": 33,
    "objfloatparam_size_factor": 34,
    "objstringparam_unique_id": 35,
    "objintparam_visible": 36,
    "objintparam_unique_id": 37,
    "objintparam_hierarchycolor": 38,
    "visionintparam_perspective_operation": 1018,
    "visionfarrayparam_viewfrustum": 1019,
    "visionintparam_rgbignored": 1020,
    "visionintparam_depthignored": 1021,
    "jointfloatparam_screw_pitch": 2034,
    "jointfloatparam_step_size": 2035,
    "jointfloatparam_maxvel": 2036,
    "jointfloatparam_maxaccel": 2037,
    "jointfloatparam_maxjerk": 2038,
    "jointintparam_dynctrlmode": 2039,
    "jointintparam_dynvelctrltype": 2040,
    "jointintparam_dynposctrltype": 2041,
    "jointfloatparam_screwlead": 2042,
    "shapefloatparam_init_ang_velocity_x": 3020,
    "shapefloatparam_init_ang_velocity_y": 3021,
    "shapefloatparam_init_ang_velocity_z": 3022,
    "shapestringparam_color_name": 3023,
    "shapeintparam_edge_visibility": 3024,
    "shapefloatparam_shading_angle": 3025,
    "shapefloatparam_edge_angle": 3026,
    "shapeintparam_edge_borders_hidden": 3027,
    "shapeintparam_component_cnt": 3028,
    "shapeintparam_sleepmodestart": 3029,
    "shapeintparam_kinematic": 3030,
    "shapeintparam_respondablesuspendcnt": 3031,
    "shapestringparam_colorname": 3032,
    "proxintparam_ray_invisibility": 4000,
    "proxintparam_volume_type": 4001,
    "proxintparam_entity_to_detect": 4002,
    "lightfloatparam_spot_exponent": 8001,
    "lightfloatparam_spot_cutoff": 8002,
    "lightfloatparam_const_attenuation": 8003,
    "lightfloatparam_lin_attenuation": 8004,
    "lightfloatparam_quad_attenuation": 8005,
    "camerafloatparam_near_clipping": 9008,
    "camerafloatparam_far_clipping": 9009,
    "cameraintparam_perspective_operation": 9010,
    "cameraintparam_trackedobject": 9011,
    "cameraintparam_remotecameramode": 9012,
    "camerafarrayparam_viewfrustum": 9013,
    "dummyintparam_dummytype": 10000,
    "dummyintparam_follow_path": 10001,
    "dummyfloatparam_follow_path_offset": 10002,
    "dummyfloatparam_size": 10003,
    "dummystringparam_assemblytag": 10004,
    "graphintparam_needs_refresh": 10500,
    "millintparam_volume_type": 11000,
    "octreefloatparam_voxelsize": 13000,
}

_SCRIPTS = {
    **counted(
        "scriptintparam",
        "execorder execcount type handle enabled objecthandle lang autorestartonerror",
        10100,
    ),
    **counted("scriptstringparam", "description name text nameext lang", 10108),
}

_SIMULATOR = {
    **counted(
        "boolparam",
        "rosinterface_donotrunmainscript=48 online_mode xr_partrepository xr_palletrepository scene_closing "
        "show_w_emitters show_w_receivers xr_jobfunc rayvalid qglwidget execunsafe execunsafeext cansave "
        "usingscriptobjects",
    ),
    **counted(
        "intparam",
        "motionplanning_seed=35 speedmodifier dynamic_iteration_count job_count program_full_version verbosity "
        "statusbarverbosity dlgverbosity videoencoder_index exitcode bugfix1 mouseclickcounterdown "
        "mouseclickcounterup objectcreationcounter objectdestructioncounter hierarchychangecounter "
        "notifydeprecated processid processcnt",
    ),
    **counted("uint64param", "simulation_time_step_ns simulation_time_ns"),
    **counted(
        "floatparam",
        "rand simulation_time_step stereo_distance dynamic_step_size mouse_wheel_zoom_factor physicstimestep "
        "maxtrisizeabs mintrisizerel",
    ),
    **counted(
        "stringparam",
        "additional_addonscript1=11 additional_addonscript2 scene_path_and_name scene_path scene_name "
        "remoteapi_temp_file_dir job job0 scene_unique_id=118 machine_id machine_id_legacy verbosity "
        "statusbarverbosity dlgverbosity consolelogfilter startupscriptstring uniqueid tempdir tempscenedir "
        "datadir importexportdir addonpath scenedefaultdir modeldefaultdir defaultpython additionalpythonpath "
        "luadir pythondir mujocodir usersettingsdir systemdir resourcesdir legacymachinetag addondir sandboxlang",
    ),
    **counted(
        "arrayparam",
        "gravity fog fog_color background_color1 background_color2 ambient_light random_euler rayorigin raydirection",
    ),
}

NUMBERS: Mapping[str, int] = MappingProxyType({**_OBJECTS, **_SCRIPTS, **_SIMULATOR})
