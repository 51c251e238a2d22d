"""Generated from the table by ``python -m simx_client.legacy.stubs``; do not edit."""

from collections.abc import Iterable
from typing import Any, SupportsFloat, SupportsIndex

from simx_client.calls.images import DepthBuffer, VisionImage
from simx_client.client import Client as Client

sim_object_shape_type: int
sim_object_joint_type: int
sim_object_graph_type: int
sim_object_camera_type: int
sim_object_dummy_type: int
sim_object_proximitysensor_type: int
sim_object_reserved1: int
sim_object_reserved2: int
sim_object_path_type: int
sim_object_visionsensor_type: int
sim_object_volume_type: int
sim_object_mill_type: int
sim_object_forcesensor_type: int
sim_object_light_type: int
sim_object_mirror_type: int
sim_appobj_object_type: int
sim_appobj_collision_type: int
sim_appobj_distance_type: int
sim_appobj_simulation_type: int
sim_appobj_ik_type: int
sim_appobj_constraintsolver_type: int
sim_appobj_collection_type: int
sim_appobj_ui_type: int
sim_appobj_script_type: int
sim_appobj_pathplanning_type: int
sim_appobj_RESERVED_type: int
sim_appobj_texture_type: int
sim_ik_pseudo_inverse_method: int
sim_ik_damped_least_squares_method: int
sim_ik_jacobian_transpose_method: int
sim_ik_x_constraint: int
sim_ik_y_constraint: int
sim_ik_z_constraint: int
sim_ik_alpha_beta_constraint: int
sim_ik_gamma_constraint: int
sim_ik_avoidance_constraint: int
sim_ikresult_not_performed: int
sim_ikresult_success: int
sim_ikresult_fail: int
sim_light_omnidirectional_subtype: int
sim_light_spot_subtype: int
sim_light_directional_subtype: int
sim_joint_revolute_subtype: int
sim_joint_prismatic_subtype: int
sim_joint_spherical_subtype: int
sim_shape_simpleshape_subtype: int
sim_shape_multishape_subtype: int
sim_proximitysensor_pyramid_subtype: int
sim_proximitysensor_cylinder_subtype: int
sim_proximitysensor_disc_subtype: int
sim_proximitysensor_cone_subtype: int
sim_proximitysensor_ray_subtype: int
sim_mill_pyramid_subtype: int
sim_mill_cylinder_subtype: int
sim_mill_disc_subtype: int
sim_mill_cone_subtype: int
sim_object_no_subtype: int
sim_objectspecialproperty_collidable: int
sim_objectspecialproperty_measurable: int
sim_objectspecialproperty_detectable_ultrasonic: int
sim_objectspecialproperty_detectable_infrared: int
sim_objectspecialproperty_detectable_laser: int
sim_objectspecialproperty_detectable_inductive: int
sim_objectspecialproperty_detectable_capacitive: int
sim_objectspecialproperty_renderable: int
sim_objectspecialproperty_detectable_all: int
sim_objectspecialproperty_cuttable: int
sim_objectspecialproperty_pathplanning_ignored: int
sim_modelproperty_not_collidable: int
sim_modelproperty_not_measurable: int
sim_modelproperty_not_renderable: int
sim_modelproperty_not_detectable: int
sim_modelproperty_not_cuttable: int
sim_modelproperty_not_dynamic: int
sim_modelproperty_not_respondable: int
sim_modelproperty_not_reset: int
sim_modelproperty_not_visible: int
sim_modelproperty_not_model: int
sim_message_ui_button_state_change: int
sim_message_reserved9: int
sim_message_object_selection_changed: int
sim_message_reserved10: int
sim_message_model_loaded: int
sim_message_reserved11: int
sim_message_keypress: int
sim_message_bannerclicked: int
sim_message_for_c_api_only_start: int
sim_message_reserved1: int
sim_message_reserved2: int
sim_message_reserved3: int
sim_message_eventcallback_scenesave: int
sim_message_eventcallback_modelsave: int
sim_message_eventcallback_moduleopen: int
sim_message_eventcallback_modulehandle: int
sim_message_eventcallback_moduleclose: int
sim_message_reserved4: int
sim_message_reserved5: int
sim_message_reserved6: int
sim_message_reserved7: int
sim_message_eventcallback_instancepass: int
sim_message_eventcallback_broadcast: int
sim_message_eventcallback_imagefilter_enumreset: int
sim_message_eventcallback_imagefilter_enumerate: int
sim_message_eventcallback_imagefilter_adjustparams: int
sim_message_eventcallback_imagefilter_reserved: int
sim_message_eventcallback_imagefilter_process: int
sim_message_eventcallback_reserved1: int
sim_message_eventcallback_reserved2: int
sim_message_eventcallback_reserved3: int
sim_message_eventcallback_reserved4: int
sim_message_eventcallback_abouttoundo: int
sim_message_eventcallback_undoperformed: int
sim_message_eventcallback_abouttoredo: int
sim_message_eventcallback_redoperformed: int
sim_message_eventcallback_scripticondblclick: int
sim_message_eventcallback_simulationabouttostart: int
sim_message_eventcallback_simulationended: int
sim_message_eventcallback_reserved5: int
sim_message_eventcallback_keypress: int
sim_message_eventcallback_modulehandleinsensingpart: int
sim_message_eventcallback_renderingpass: int
sim_message_eventcallback_bannerclicked: int
sim_message_eventcallback_menuitemselected: int
sim_message_eventcallback_refreshdialogs: int
sim_message_eventcallback_sceneloaded: int
sim_message_eventcallback_modelloaded: int
sim_message_eventcallback_instanceswitch: int
sim_message_eventcallback_guipass: int
sim_message_eventcallback_mainscriptabouttobecalled: int
sim_message_eventcallback_rmlposition: int
sim_message_eventcallback_rmlvelocity: int
sim_message_simulation_start_resume_request: int
sim_message_simulation_pause_request: int
sim_message_simulation_stop_request: int
sim_objectproperty_reserved1: int
sim_objectproperty_reserved2: int
sim_objectproperty_reserved3: int
sim_objectproperty_reserved4: int
sim_objectproperty_reserved5: int
sim_objectproperty_reserved6: int
sim_objectproperty_collapsed: int
sim_objectproperty_selectable: int
sim_objectproperty_reserved7: int
sim_objectproperty_selectmodelbaseinstead: int
sim_objectproperty_dontshowasinsidemodel: int
sim_objectproperty_canupdatedna: int
sim_objectproperty_selectinvisible: int
sim_objectproperty_depthinvisible: int
sim_lua_arg_nil: int
sim_lua_arg_bool: int
sim_lua_arg_int: int
sim_lua_arg_float: int
sim_lua_arg_string: int
sim_lua_arg_invalid: int
sim_lua_arg_table: int
sim_ui_property_visible: int
sim_ui_property_visibleduringsimulationonly: int
sim_ui_property_moveable: int
sim_ui_property_relativetoleftborder: int
sim_ui_property_relativetotopborder: int
sim_ui_property_fixedwidthfont: int
sim_ui_property_systemblock: int
sim_ui_property_settocenter: int
sim_ui_property_rolledup: int
sim_ui_property_selectassociatedobject: int
sim_ui_property_visiblewhenobjectselected: int
sim_buttonproperty_button: int
sim_buttonproperty_label: int
sim_buttonproperty_slider: int
sim_buttonproperty_editbox: int
sim_buttonproperty_staydown: int
sim_buttonproperty_enabled: int
sim_buttonproperty_borderless: int
sim_buttonproperty_horizontallycentered: int
sim_buttonproperty_ignoremouse: int
sim_buttonproperty_isdown: int
sim_buttonproperty_transparent: int
sim_buttonproperty_nobackgroundcolor: int
sim_buttonproperty_rollupaction: int
sim_buttonproperty_closeaction: int
sim_buttonproperty_verticallycentered: int
sim_buttonproperty_downupevent: int
sim_simulation_stopped: int
sim_simulation_paused: int
sim_simulation_advancing: int
sim_simulation_advancing_firstafterstop: int
sim_simulation_advancing_running: int
sim_simulation_advancing_lastbeforepause: int
sim_simulation_advancing_firstafterpause: int
sim_simulation_advancing_abouttostop: int
sim_simulation_advancing_lastbeforestop: int
sim_script_no_error: int
sim_script_main_script_nonexistent: int
sim_script_main_script_not_called: int
sim_script_reentrance_error: int
sim_script_lua_error: int
sim_script_call_error: int
sim_scripttype_mainscript: int
sim_scripttype_childscript: int
sim_scripttype_jointctrlcallback: int
sim_scripttype_contactcallback: int
sim_scripttype_customizationscript: int
sim_scripttype_generalcallback: int
sim_api_errormessage_ignore: int
sim_api_errormessage_report: int
sim_api_errormessage_output: int
sim_handle_all: int
sim_handle_all_except_explicit: int
sim_handle_self: int
sim_handle_main_script: int
sim_handle_tree: int
sim_handle_chain: int
sim_handle_single: int
sim_handle_default: int
sim_handle_all_except_self: int
sim_handle_parent: int
sim_handleflag_assembly: int
sim_handleflag_model: int
sim_distcalcmethod_dl: int
sim_distcalcmethod_dac: int
sim_distcalcmethod_max_dl_dac: int
sim_distcalcmethod_dl_and_dac: int
sim_distcalcmethod_sqrt_dl2_and_dac2: int
sim_distcalcmethod_dl_if_nonzero: int
sim_distcalcmethod_dac_if_nonzero: int
sim_dlgstyle_message: int
sim_dlgstyle_input: int
sim_dlgstyle_ok: int
sim_dlgstyle_ok_cancel: int
sim_dlgstyle_yes_no: int
sim_dlgstyle_dont_center: int
sim_dlgret_still_open: int
sim_dlgret_ok: int
sim_dlgret_cancel: int
sim_dlgret_yes: int
sim_dlgret_no: int
sim_pathproperty_show_line: int
sim_pathproperty_show_orientation: int
sim_pathproperty_closed_path: int
sim_pathproperty_automatic_orientation: int
sim_pathproperty_invert_velocity: int
sim_pathproperty_infinite_acceleration: int
sim_pathproperty_flat_path: int
sim_pathproperty_show_position: int
sim_pathproperty_auto_velocity_profile_translation: int
sim_pathproperty_auto_velocity_profile_rotation: int
sim_pathproperty_endpoints_at_zero: int
sim_pathproperty_keep_x_up: int
sim_drawing_points: int
sim_drawing_lines: int
sim_drawing_triangles: int
sim_drawing_trianglepoints: int
sim_drawing_quadpoints: int
sim_drawing_discpoints: int
sim_drawing_cubepoints: int
sim_drawing_spherepoints: int
sim_drawing_itemcolors: int
sim_drawing_vertexcolors: int
sim_drawing_itemsizes: int
sim_drawing_backfaceculling: int
sim_drawing_wireframe: int
sim_drawing_painttag: int
sim_drawing_followparentvisibility: int
sim_drawing_cyclic: int
sim_drawing_50percenttransparency: int
sim_drawing_25percenttransparency: int
sim_drawing_12percenttransparency: int
sim_drawing_emissioncolor: int
sim_drawing_facingcamera: int
sim_drawing_overlay: int
sim_drawing_itemtransparency: int
sim_banner_left: int
sim_banner_right: int
sim_banner_nobackground: int
sim_banner_overlay: int
sim_banner_followparentvisibility: int
sim_banner_clickselectsparent: int
sim_banner_clicktriggersevent: int
sim_banner_facingcamera: int
sim_banner_fullyfacingcamera: int
sim_banner_backfaceculling: int
sim_banner_keepsamesize: int
sim_banner_bitmapfont: int
sim_particle_points1: int
sim_particle_points2: int
sim_particle_points4: int
sim_particle_roughspheres: int
sim_particle_spheres: int
sim_particle_respondable1to4: int
sim_particle_respondable5to8: int
sim_particle_particlerespondable: int
sim_particle_ignoresgravity: int
sim_particle_invisible: int
sim_particle_itemsizes: int
sim_particle_itemdensities: int
sim_particle_itemcolors: int
sim_particle_cyclic: int
sim_particle_emissioncolor: int
sim_particle_water: int
sim_particle_painttag: int
sim_ui_menu_title: int
sim_ui_menu_minimize: int
sim_ui_menu_close: int
sim_ui_menu_systemblock: int
sim_boolparam_hierarchy_visible: int
sim_boolparam_console_visible: int
sim_boolparam_collision_handling_enabled: int
sim_boolparam_distance_handling_enabled: int
sim_boolparam_ik_handling_enabled: int
sim_boolparam_gcs_handling_enabled: int
sim_boolparam_dynamics_handling_enabled: int
sim_boolparam_joint_motion_handling_enabled: int
sim_boolparam_path_motion_handling_enabled: int
sim_boolparam_proximity_sensor_handling_enabled: int
sim_boolparam_vision_sensor_handling_enabled: int
sim_boolparam_mill_handling_enabled: int
sim_boolparam_browser_visible: int
sim_boolparam_scene_and_model_load_messages: int
sim_reserved0: int
sim_boolparam_shape_textures_are_visible: int
sim_boolparam_display_enabled: int
sim_boolparam_infotext_visible: int
sim_boolparam_statustext_open: int
sim_boolparam_fog_enabled: int
sim_boolparam_rml2_available: int
sim_boolparam_rml4_available: int
sim_boolparam_mirrors_enabled: int
sim_boolparam_aux_clip_planes_enabled: int
sim_boolparam_full_model_copy_from_api: int
sim_boolparam_realtime_simulation: int
sim_boolparam_force_show_wireless_emission: int
sim_boolparam_force_show_wireless_reception: int
sim_boolparam_video_recording_triggered: int
sim_boolparam_threaded_rendering_enabled: int
sim_boolparam_fullscreen: int
sim_boolparam_headless: int
sim_boolparam_hierarchy_toolbarbutton_enabled: int
sim_boolparam_browser_toolbarbutton_enabled: int
sim_boolparam_objectshift_toolbarbutton_enabled: int
sim_boolparam_objectrotate_toolbarbutton_enabled: int
sim_boolparam_force_calcstruct_all_visible: int
sim_boolparam_force_calcstruct_all: int
sim_boolparam_exit_request: int
sim_boolparam_play_toolbarbutton_enabled: int
sim_boolparam_pause_toolbarbutton_enabled: int
sim_boolparam_stop_toolbarbutton_enabled: int
sim_boolparam_waiting_for_trigger: int
sim_intparam_error_report_mode: int
sim_intparam_program_version: int
sim_intparam_instance_count: int
sim_intparam_custom_cmd_start_id: int
sim_intparam_compilation_version: int
sim_intparam_current_page: int
sim_intparam_flymode_camera_handle: int
sim_intparam_dynamic_step_divider: int
sim_intparam_dynamic_engine: int
sim_intparam_server_port_start: int
sim_intparam_server_port_range: int
sim_intparam_visible_layers: int
sim_intparam_infotext_style: int
sim_intparam_settings: int
sim_intparam_edit_mode_type: int
sim_intparam_server_port_next: int
sim_intparam_qt_version: int
sim_intparam_event_flags_read: int
sim_intparam_event_flags_read_clear: int
sim_intparam_platform: int
sim_intparam_scene_unique_id: int
sim_intparam_work_thread_count: int
sim_intparam_mouse_x: int
sim_intparam_mouse_y: int
sim_intparam_core_count: int
sim_intparam_work_thread_calc_time_ms: int
sim_intparam_idle_fps: int
sim_intparam_prox_sensor_select_down: int
sim_intparam_prox_sensor_select_up: int
sim_intparam_stop_request_counter: int
sim_intparam_program_revision: int
sim_intparam_mouse_buttons: int
sim_intparam_dynamic_warning_disabled_mask: int
sim_intparam_simulation_warning_disabled_mask: int
sim_intparam_scene_index: int
sim_intparam_motionplanning_seed: int
sim_intparam_speedmodifier: int
sim_floatparam_rand: int
sim_floatparam_simulation_time_step: int
sim_floatparam_stereo_distance: int
sim_stringparam_application_path: int
sim_stringparam_video_filename: int
sim_stringparam_app_arg1: int
sim_stringparam_app_arg2: int
sim_stringparam_app_arg3: int
sim_stringparam_app_arg4: int
sim_stringparam_app_arg5: int
sim_stringparam_app_arg6: int
sim_stringparam_app_arg7: int
sim_stringparam_app_arg8: int
sim_stringparam_app_arg9: int
sim_stringparam_scene_path_and_name: int
sim_arrayparam_gravity: int
sim_arrayparam_fog: int
sim_arrayparam_fog_color: int
sim_arrayparam_background_color1: int
sim_arrayparam_background_color2: int
sim_arrayparam_ambient_light: int
sim_arrayparam_random_euler: int
sim_objintparam_visibility_layer: int
sim_objfloatparam_abs_x_velocity: int
sim_objfloatparam_abs_y_velocity: int
sim_objfloatparam_abs_z_velocity: int
sim_objfloatparam_abs_rot_velocity: int
sim_objfloatparam_objbbox_min_x: int
sim_objfloatparam_objbbox_min_y: int
sim_objfloatparam_objbbox_min_z: int
sim_objfloatparam_objbbox_max_x: int
sim_objfloatparam_objbbox_max_y: int
sim_objfloatparam_objbbox_max_z: int
sim_objfloatparam_modelbbox_min_x: int
sim_objfloatparam_modelbbox_min_y: int
sim_objfloatparam_modelbbox_min_z: int
sim_objfloatparam_modelbbox_max_x: int
sim_objfloatparam_modelbbox_max_y: int
sim_objfloatparam_modelbbox_max_z: int
sim_objintparam_collection_self_collision_indicator: int
sim_objfloatparam_transparency_offset: int
sim_objintparam_child_role: int
sim_objintparam_parent_role: int
sim_objintparam_manipulation_permissions: int
sim_objintparam_illumination_handle: int
sim_visionfloatparam_near_clipping: int
sim_visionfloatparam_far_clipping: int
sim_visionintparam_resolution_x: int
sim_visionintparam_resolution_y: int
sim_visionfloatparam_perspective_angle: int
sim_visionfloatparam_ortho_size: int
sim_visionintparam_disabled_light_components: int
sim_visionintparam_rendering_attributes: int
sim_visionintparam_entity_to_render: int
sim_visionintparam_windowed_size_x: int
sim_visionintparam_windowed_size_y: int
sim_visionintparam_windowed_pos_x: int
sim_visionintparam_windowed_pos_y: int
sim_visionintparam_pov_focal_blur: int
sim_visionfloatparam_pov_blur_distance: int
sim_visionfloatparam_pov_aperture: int
sim_visionintparam_pov_blur_sampled: int
sim_visionintparam_render_mode: int
sim_jointintparam_motor_enabled: int
sim_jointintparam_ctrl_enabled: int
sim_jointfloatparam_pid_p: int
sim_jointfloatparam_pid_i: int
sim_jointfloatparam_pid_d: int
sim_jointfloatparam_intrinsic_x: int
sim_jointfloatparam_intrinsic_y: int
sim_jointfloatparam_intrinsic_z: int
sim_jointfloatparam_intrinsic_qx: int
sim_jointfloatparam_intrinsic_qy: int
sim_jointfloatparam_intrinsic_qz: int
sim_jointfloatparam_intrinsic_qw: int
sim_jointfloatparam_velocity: int
sim_jointfloatparam_spherical_qx: int
sim_jointfloatparam_spherical_qy: int
sim_jointfloatparam_spherical_qz: int
sim_jointfloatparam_spherical_qw: int
sim_jointfloatparam_upper_limit: int
sim_jointfloatparam_kc_k: int
sim_jointfloatparam_kc_c: int
sim_jointfloatparam_ik_weight: int
sim_jointfloatparam_error_x: int
sim_jointfloatparam_error_y: int
sim_jointfloatparam_error_z: int
sim_jointfloatparam_error_a: int
sim_jointfloatparam_error_b: int
sim_jointfloatparam_error_g: int
sim_jointfloatparam_error_pos: int
sim_jointfloatparam_error_angle: int
sim_jointintparam_velocity_lock: int
sim_jointintparam_vortex_dep_handle: int
sim_jointfloatparam_vortex_dep_multiplication: int
sim_jointfloatparam_vortex_dep_offset: int
sim_shapefloatparam_init_velocity_x: int
sim_shapefloatparam_init_velocity_y: int
sim_shapefloatparam_init_velocity_z: int
sim_shapeintparam_static: int
sim_shapeintparam_respondable: int
sim_shapefloatparam_mass: int
sim_shapefloatparam_texture_x: int
sim_shapefloatparam_texture_y: int
sim_shapefloatparam_texture_z: int
sim_shapefloatparam_texture_a: int
sim_shapefloatparam_texture_b: int
sim_shapefloatparam_texture_g: int
sim_shapefloatparam_texture_scaling_x: int
sim_shapefloatparam_texture_scaling_y: int
sim_shapeintparam_culling: int
sim_shapeintparam_wireframe: int
sim_shapeintparam_compound: int
sim_shapeintparam_convex: int
sim_shapeintparam_convex_check: int
sim_shapeintparam_respondable_mask: int
sim_shapefloatparam_init_velocity_a: int
sim_shapefloatparam_init_velocity_b: int
sim_shapefloatparam_init_velocity_g: int
sim_shapestringparam_color_name: int
sim_shapeintparam_edge_visibility: int
sim_shapefloatparam_shading_angle: int
sim_shapefloatparam_edge_angle: int
sim_shapeintparam_edge_borders_hidden: int
sim_proxintparam_ray_invisibility: int
sim_forcefloatparam_error_x: int
sim_forcefloatparam_error_y: int
sim_forcefloatparam_error_z: int
sim_forcefloatparam_error_a: int
sim_forcefloatparam_error_b: int
sim_forcefloatparam_error_g: int
sim_forcefloatparam_error_pos: int
sim_forcefloatparam_error_angle: int
sim_lightintparam_pov_casts_shadows: int
sim_cameraintparam_disabled_light_components: int
sim_camerafloatparam_perspective_angle: int
sim_camerafloatparam_ortho_size: int
sim_cameraintparam_rendering_attributes: int
sim_cameraintparam_pov_focal_blur: int
sim_camerafloatparam_pov_blur_distance: int
sim_camerafloatparam_pov_aperture: int
sim_cameraintparam_pov_blur_samples: int
sim_dummyintparam_link_type: int
sim_mirrorfloatparam_width: int
sim_mirrorfloatparam_height: int
sim_mirrorfloatparam_reflectance: int
sim_mirrorintparam_enable: int
sim_pplanfloatparam_x_min: int
sim_pplanfloatparam_x_range: int
sim_pplanfloatparam_y_min: int
sim_pplanfloatparam_y_range: int
sim_pplanfloatparam_z_min: int
sim_pplanfloatparam_z_range: int
sim_pplanfloatparam_delta_min: int
sim_pplanfloatparam_delta_range: int
sim_mplanintparam_nodes_computed: int
sim_mplanintparam_prepare_nodes: int
sim_mplanintparam_clear_nodes: int
sim_gui_menubar: int
sim_gui_popups: int
sim_gui_toolbar1: int
sim_gui_toolbar2: int
sim_gui_hierarchy: int
sim_gui_infobar: int
sim_gui_statusbar: int
sim_gui_scripteditor: int
sim_gui_scriptsimulationparameters: int
sim_gui_dialogs: int
sim_gui_browser: int
sim_gui_all: int
sim_jointmode_passive: int
sim_jointmode_motion: int
sim_jointmode_ik: int
sim_jointmode_ikdependent: int
sim_jointmode_dependent: int
sim_jointmode_force: int
sim_navigation_passive: int
sim_navigation_camerashift: int
sim_navigation_camerarotate: int
sim_navigation_camerazoom: int
sim_navigation_cameratilt: int
sim_navigation_cameraangle: int
sim_navigation_camerafly: int
sim_navigation_objectshift: int
sim_navigation_objectrotate: int
sim_navigation_reserved2: int
sim_navigation_reserved3: int
sim_navigation_jointpathtest: int
sim_navigation_ikmanip: int
sim_navigation_objectmultipleselection: int
sim_navigation_reserved4: int
sim_navigation_clickselection: int
sim_navigation_ctrlselection: int
sim_navigation_shiftselection: int
sim_navigation_camerazoomwheel: int
sim_navigation_camerarotaterightbutton: int
SIMX_VERSION: int
SIMX_HEADER_SIZE: int
simx_headeroffset_crc: int
simx_headeroffset_version: int
simx_headeroffset_message_id: int
simx_headeroffset_client_time: int
simx_headeroffset_server_time: int
simx_headeroffset_scene_id: int
simx_headeroffset_server_state: int
SIMX_SUBHEADER_SIZE: int
simx_cmdheaderoffset_mem_size: int
simx_cmdheaderoffset_full_mem_size: int
simx_cmdheaderoffset_pdata_offset0: int
simx_cmdheaderoffset_pdata_offset1: int
simx_cmdheaderoffset_cmd: int
simx_cmdheaderoffset_delay_or_split: int
simx_cmdheaderoffset_sim_time: int
simx_cmdheaderoffset_status: int
simx_cmdheaderoffset_reserved: int
simx_opmode_oneshot: int
simx_opmode_blocking: int
simx_opmode_oneshot_wait: int
simx_opmode_continuous: int
simx_opmode_streaming: int
simx_opmode_oneshot_split: int
simx_opmode_continuous_split: int
simx_opmode_streaming_split: int
simx_opmode_discontinue: int
simx_opmode_buffer: int
simx_opmode_remove: int
simx_return_ok: int
simx_return_novalue_flag: int
simx_return_timeout_flag: int
simx_return_illegal_opmode_flag: int
simx_return_remote_error_flag: int
simx_return_split_progress_flag: int
simx_return_local_error_flag: int
simx_return_initialize_error_flag: int
simx_error_noerror: int
simx_error_novalue_flag: int
simx_error_timeout_flag: int
simx_error_illegal_opmode_flag: int
simx_error_remote_error_flag: int
simx_error_split_progress_flag: int
simx_error_local_error_flag: int
simx_error_initialize_error_flag: int
def simxStart(connectionAddress: str | bytes, connectionPort: SupportsIndex, waitUntilConnected: bool | int, doNotReconnectOnceDisconnected: bool | int, timeOutInMs: SupportsIndex, commThreadCycleInMs: SupportsIndex) -> int: ...
def simxFinish(clientID: SupportsIndex) -> None: ...
def simxGetConnectionId(clientID: SupportsIndex) -> int: ...
def simxGetPingTime(clientID: SupportsIndex) -> tuple[int, int]: ...
def simxGetLastCmdTime(clientID: SupportsIndex) -> int: ...
def simxPauseCommunication(clientID: SupportsIndex, enable: bool | int) -> int: ...
def simxGetInMessageInfo(clientID: SupportsIndex, infoType: SupportsIndex) -> tuple[int, int]: ...
def simxGetOutMessageInfo(clientID: SupportsIndex, infoType: SupportsIndex) -> tuple[int, int]: ...
def simxCreateBuffer(bufferSize: SupportsIndex) -> Any: ...
def simxReleaseBuffer(buffer: Any) -> None: ...
def simxPackInts(intList: Any) -> bytearray: ...
def simxUnpackInts(intsPackedInString: Any) -> list[int]: ...
def simxPackFloats(floatList: Any) -> bytearray: ...
def simxUnpackFloats(floatsPackedInString: Any) -> list[float]: ...
def simxQuery(clientID: SupportsIndex, signalName: str | bytes, signalValue: Any, retSignalName: str | bytes, timeOutInMs: SupportsIndex) -> tuple[int, bytearray]: ...
def simxTransferFile(clientID: SupportsIndex, filePathAndName: str | bytes, fileName_serverSide: str | bytes, timeOut: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxSynchronous(clientID: SupportsIndex, enable: bool | int) -> int: ...
def simxSynchronousTrigger(clientID: SupportsIndex) -> int: ...
def simxStartSimulation(clientID: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxPauseSimulation(clientID: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxStopSimulation(clientID: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxLoadScene(clientID: SupportsIndex, scenePathAndName: str | bytes, options: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxCloseScene(clientID: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetObjectHandle(clientID: SupportsIndex, objectName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetObjects(clientID: SupportsIndex, objectType: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[int]]: ...
def simxGetObjectParent(clientID: SupportsIndex, childObjectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetObjectChild(clientID: SupportsIndex, parentObjectHandle: SupportsIndex, childIndex: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxSetObjectParent(clientID: SupportsIndex, objectHandle: SupportsIndex, parentObject: SupportsIndex, keepInPlace: bool | int, operationMode: SupportsIndex) -> int: ...
def simxGetObjectPosition(clientID: SupportsIndex, objectHandle: SupportsIndex, relativeToObjectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float]]: ...
def simxSetObjectPosition(clientID: SupportsIndex, objectHandle: SupportsIndex, relativeToObjectHandle: SupportsIndex, position: Iterable[SupportsFloat], operationMode: SupportsIndex) -> int: ...
def simxGetObjectOrientation(clientID: SupportsIndex, objectHandle: SupportsIndex, relativeToObjectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float]]: ...
def simxSetObjectOrientation(clientID: SupportsIndex, objectHandle: SupportsIndex, relativeToObjectHandle: SupportsIndex, eulerAngles: Iterable[SupportsFloat], operationMode: SupportsIndex) -> int: ...
def simxGetObjectQuaternion(clientID: SupportsIndex, objectHandle: SupportsIndex, relativeToObjectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float]]: ...
def simxSetObjectQuaternion(clientID: SupportsIndex, objectHandle: SupportsIndex, relativeToObjectHandle: SupportsIndex, quaternion: Iterable[SupportsFloat], operationMode: SupportsIndex) -> int: ...
def simxGetObjectVelocity(clientID: SupportsIndex, objectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float], list[float]]: ...
def simxGetObjectGroupData(clientID: SupportsIndex, objectType: SupportsIndex, dataType: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[int], list[int], list[float], list[str]]: ...
def simxRemoveObject(clientID: SupportsIndex, objectHandle: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxRemoveModel(clientID: SupportsIndex, objectHandle: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxLoadModel(clientID: SupportsIndex, modelPathAndName: str | bytes, options: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxCopyPasteObjects(clientID: SupportsIndex, objectHandles: Iterable[SupportsIndex], operationMode: SupportsIndex) -> tuple[int, list[int]]: ...
def simxCreateDummy(clientID: SupportsIndex, size: SupportsFloat, color: Iterable[SupportsIndex] | None, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetObjectSelection(clientID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[int]]: ...
def simxSetObjectSelection(clientID: SupportsIndex, objectHandles: Iterable[SupportsIndex], operationMode: SupportsIndex) -> int: ...
def simxGetJointPosition(clientID: SupportsIndex, jointHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxSetJointPosition(clientID: SupportsIndex, jointHandle: SupportsIndex, position: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxGetJointMatrix(clientID: SupportsIndex, jointHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float]]: ...
def simxSetSphericalJointMatrix(clientID: SupportsIndex, jointHandle: SupportsIndex, matrix: Iterable[SupportsFloat], operationMode: SupportsIndex) -> int: ...
def simxSetJointTargetVelocity(clientID: SupportsIndex, jointHandle: SupportsIndex, targetVelocity: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxSetJointTargetPosition(clientID: SupportsIndex, jointHandle: SupportsIndex, targetPosition: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxGetJointForce(clientID: SupportsIndex, jointHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxJointGetForce(clientID: SupportsIndex, jointHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxGetJointMaxForce(clientID: SupportsIndex, jointHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxSetJointForce(clientID: SupportsIndex, jointHandle: SupportsIndex, force: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxSetJointMaxForce(clientID: SupportsIndex, jointHandle: SupportsIndex, force: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxReadProximitySensor(clientID: SupportsIndex, sensorHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, bool, list[float], int, list[float]]: ...
def simxReadForceSensor(clientID: SupportsIndex, forceSensorHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int, list[float], list[float]]: ...
def simxBreakForceSensor(clientID: SupportsIndex, forceSensorHandle: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxReadVisionSensor(clientID: SupportsIndex, sensorHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, bool, list[list[float]]]: ...
def simxGetVisionSensorImage(clientID: SupportsIndex, sensorHandle: SupportsIndex, options: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[int], VisionImage]: ...
def simxSetVisionSensorImage(clientID: SupportsIndex, sensorHandle: SupportsIndex, image: Iterable[SupportsIndex], options: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetVisionSensorDepthBuffer(clientID: SupportsIndex, sensorHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[int], DepthBuffer]: ...
def simxCheckCollision(clientID: SupportsIndex, entity1: SupportsIndex, entity2: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, bool]: ...
def simxReadCollision(clientID: SupportsIndex, collisionObjectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, bool]: ...
def simxGetCollisionHandle(clientID: SupportsIndex, collisionObjectName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxCheckDistance(clientID: SupportsIndex, entity1: SupportsIndex, entity2: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxReadDistance(clientID: SupportsIndex, distanceObjectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxGetDistanceHandle(clientID: SupportsIndex, distanceObjectName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetCollectionHandle(clientID: SupportsIndex, collectionName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetObjectFloatParameter(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxGetObjectFloatParam(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxSetObjectFloatParameter(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, parameterValue: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxSetObjectFloatParam(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, parameterValue: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxGetObjectIntParameter(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetObjectInt32Param(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxSetObjectIntParameter(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, parameterValue: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxSetObjectInt32Param(clientID: SupportsIndex, objectHandle: SupportsIndex, parameterID: SupportsIndex, parameterValue: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetModelProperty(clientID: SupportsIndex, objectHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxSetModelProperty(clientID: SupportsIndex, objectHandle: SupportsIndex, prop: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetBooleanParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, bool]: ...
def simxGetBoolParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, bool]: ...
def simxSetBooleanParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValue: bool | int, operationMode: SupportsIndex) -> int: ...
def simxSetBoolParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValue: bool | int, operationMode: SupportsIndex) -> int: ...
def simxGetIntegerParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetInt32Param(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxSetIntegerParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValue: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxSetInt32Param(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValue: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetFloatingParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxGetFloatParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxSetFloatingParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValue: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxSetFloatParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValue: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxGetStringParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, str]: ...
def simxGetStringParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, str]: ...
def simxGetArrayParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float]]: ...
def simxGetArrayParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[float]]: ...
def simxSetArrayParameter(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValues: Iterable[SupportsFloat], operationMode: SupportsIndex) -> int: ...
def simxSetArrayParam(clientID: SupportsIndex, paramIdentifier: SupportsIndex, paramValues: Iterable[SupportsFloat], operationMode: SupportsIndex) -> int: ...
def simxSetFloatSignal(clientID: SupportsIndex, signalName: str | bytes, signalValue: SupportsFloat, operationMode: SupportsIndex) -> int: ...
def simxGetFloatSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> tuple[int, float]: ...
def simxClearFloatSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxSetIntegerSignal(clientID: SupportsIndex, signalName: str | bytes, signalValue: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxSetInt32Signal(clientID: SupportsIndex, signalName: str | bytes, signalValue: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetIntegerSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetInt32Signal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxClearIntegerSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxClearInt32Signal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxSetStringSignal(clientID: SupportsIndex, signalName: str | bytes, signalValue: bytes | bytearray | str | memoryview, operationMode: SupportsIndex) -> int: ...
def simxGetStringSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> tuple[int, bytearray]: ...
def simxClearStringSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxAppendStringSignal(clientID: SupportsIndex, signalName: str | bytes, signalValue: bytes | bytearray | str | memoryview, operationMode: SupportsIndex) -> int: ...
def simxWriteStringStream(clientID: SupportsIndex, signalName: str | bytes, signalValue: bytes | bytearray | str | memoryview, operationMode: SupportsIndex) -> int: ...
def simxReadStringStream(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> tuple[int, bytearray]: ...
def simxGetAndClearStringSignal(clientID: SupportsIndex, signalName: str | bytes, operationMode: SupportsIndex) -> tuple[int, bytearray]: ...
def simxCallScriptFunction(clientID: SupportsIndex, scriptDescription: str | bytes, options: SupportsIndex, functionName: str | bytes, inputInts: Iterable[SupportsIndex], inputFloats: Iterable[SupportsFloat], inputStrings: Iterable[str], inputBuffer: bytes | bytearray | str | memoryview, operationMode: SupportsIndex) -> tuple[int, list[int], list[float], list[str], bytearray]: ...
def simxGetLastErrors(clientID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[str]]: ...
def simxAddStatusbarMessage(clientID: SupportsIndex, message: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxEraseFile(clientID: SupportsIndex, fileName_serverSide: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxAuxiliaryConsoleOpen(clientID: SupportsIndex, title: str | bytes, maxLines: SupportsIndex, mode: SupportsIndex, position: Iterable[SupportsIndex] | None, size: Iterable[SupportsIndex] | None, textColor: Iterable[SupportsFloat] | None, backgroundColor: Iterable[SupportsFloat] | None, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxAuxiliaryConsoleClose(clientID: SupportsIndex, consoleHandle: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxAuxiliaryConsolePrint(clientID: SupportsIndex, consoleHandle: SupportsIndex, txt: str | bytes | None, operationMode: SupportsIndex) -> int: ...
def simxAuxiliaryConsoleShow(clientID: SupportsIndex, consoleHandle: SupportsIndex, showState: bool | int, operationMode: SupportsIndex) -> int: ...
def simxDisplayDialog(clientID: SupportsIndex, titleText: str | bytes, mainText: str | bytes, dialogType: SupportsIndex, initialText: str | bytes, titleColors: Iterable[SupportsFloat] | None, dialogColors: Iterable[SupportsFloat] | None, operationMode: SupportsIndex) -> tuple[int, int, int]: ...
def simxEndDialog(clientID: SupportsIndex, dialogHandle: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetDialogResult(clientID: SupportsIndex, dialogHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetDialogInput(clientID: SupportsIndex, dialogHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, str]: ...
def simxGetUIHandle(clientID: SupportsIndex, uiName: str | bytes, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxGetUISlider(clientID: SupportsIndex, uiHandle: SupportsIndex, uiButtonID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxSetUISlider(clientID: SupportsIndex, uiHandle: SupportsIndex, uiButtonID: SupportsIndex, position: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxGetUIEventButton(clientID: SupportsIndex, uiHandle: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int, list[int]]: ...
def simxGetUIButtonProperty(clientID: SupportsIndex, uiHandle: SupportsIndex, uiButtonID: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, int]: ...
def simxSetUIButtonProperty(clientID: SupportsIndex, uiHandle: SupportsIndex, uiButtonID: SupportsIndex, prop: SupportsIndex, operationMode: SupportsIndex) -> int: ...
def simxSetUIButtonLabel(clientID: SupportsIndex, uiHandle: SupportsIndex, uiButtonID: SupportsIndex, upStateLabel: str | bytes, downStateLabel: str | bytes, operationMode: SupportsIndex) -> int: ...
def simxLoadUI(clientID: SupportsIndex, uiPathAndName: str | bytes, options: SupportsIndex, operationMode: SupportsIndex) -> tuple[int, list[int]]: ...
def simxRemoveUI(clientID: SupportsIndex, uiHandle: SupportsIndex, operationMode: SupportsIndex) -> int: ...

__all__: list[str]
