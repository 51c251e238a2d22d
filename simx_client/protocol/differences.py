"""Intended differences from the original: numbered, each with a test.

README shows those of `IN_README`, docs/coverage.md all. Numbers are never reused; new differences go to the
end. Handlers' docstrings mark them with `Differs:`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

IN_README = (1, 2, 5, 7, 9, 10)
"""Numbers of the differences in the README: scripts notice these first."""


NEVER = "never"
"""A program that worked with V-REP behaves the same: only scenes or new programs notice the difference."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One difference; its number is its position in `DIFFERENCES`, from 1."""

    title: str
    text: str
    """May be empty; together with the title it describes this project's behaviour."""
    test: str
    """The test of the difference, as pytest names it."""
    commands: str = ""
    """Names of the functions affected, separated by blanks; empty if no single function is affected."""
    when: str = ""
    """The habit of a program that makes it matter, for simx-check: a call of one of `commands` if empty; nothing for
    `NEVER`; else a habit that `simx_client/checking/idioms.py` recognises, by its name there."""

    @property
    def sentence(self) -> str:
        return f"**{self.title}** {self.text}".strip()


_SURPRISES = "tests/conformance/test_surprises.py::"
_CONNECTION = "tests/conformance/test_connection_functions.py::"
_OBJECTS = "tests/conformance/test_object_functions.py::"
_SENSORS = "tests/conformance/test_sensor_functions.py::"
_SIGNALS = "tests/conformance/test_signal_functions.py::"
_SCRIPTS = "tests/conformance/test_script_and_file_functions.py::"
_MODES = "tests/client/test_modes.py::"
_ZENOH = "tests/server/gateways/zenoh/test_zenoh.py::"

DIFFERENCES: tuple[Difference, ...] = (
    Difference(
        "Stop is immediate.",
        "When a blocking `simxStopSimulation` returns, the simulation is stopped and its start state "
        "is restored. V-REP needed a few more simulation steps.",
        _SURPRISES + "test_08_stop_has_happened_when_it_returns",
        "simxStopSimulation",
        when=NEVER,
    ),
    Difference(
        "A trigger answers after its step.",
        "What you read after `simxSynchronousTrigger` is the new state. Trigger and ping still works.",
        _SURPRISES + "test_06_a_trigger_answers_after_its_pass_and_trigger_with_ping_still_works",
        "simxSynchronousTrigger",
        when="a trigger without a ping",
    ),
    Difference(
        "Images are rendered on request.",
        "Only sensors with a vision script are rendered in every simulation step. Equal requests of one step share one "
        "image.",
        "tests/server/sensors/test_render_thread.py::test_equal_requests_of_one_version_render_once",
        "simxGetVisionSensorImage simxGetVisionSensorDepthBuffer simxReadVisionSensor",
        when=NEVER,
    ),
    Difference(
        "−1 comes with a reason.",
        "The number is V-REP's; a line in the log says what was tried, what was found and what to do.",
        _ZENOH + "test_nothing_there_is_minus_1_at_once_with_the_way_out",
        "simxStart",
        when=NEVER,
    ),
    Difference(
        "Blocking calls are answered between simulation steps.",
        "They cost a round trip; V-REP took up to a step. Under `simx-run` and the stand-ins for `vrep.py`, a call "
        "waits for the next step if it repeats a call or changes something. `SIMX_PACE`: `free`, `repeat`, `every`.",
        "tests/client/test_pace.py::test_a_gripper_that_is_polled_until_it_rests_is_closed",
        when="a loop of blocking calls",
    ),
    Difference(
        "Several clients on one port.",
        "V-REP served one at a time.",
        "tests/conformance/test_over_zenoh.py::test_two_processes_share_one_port",
        "simxStart",
        when=NEVER,
    ),
    Difference(
        "Port 19999 is always there.",
        "In V-REP it existed only while a simulation ran; here a connection to it starts a stopped one. The same holds "
        "for a port that a script names, as in `simRemoteApi.start(20000)`.",
        "tests/server/service/test_server_loop.py::test_joining_by_the_starting_port_starts_a_stopped_simulation",
        "simxStart",
        when="port 19999",
    ),
    Difference(
        "Images are lists that NumPy reads at once.",
        "`np.array(image, dtype=np.uint8)` works on NumPy 2, where a plain list of V-REP's signed bytes overflows.",
        "tests/protocol/test_image_value.py::test_uint8_conversion_wraps_and_resizes_in_place",
        "simxGetVisionSensorImage",
        when=NEVER,
    ),
    Difference(
        "MuJoCo does the physics.",
        "Names, signs, limits and joint behaviour are V-REP's; contact and friction are MuJoCo's.",
        "tests/server/handlers/test_handlers_simulation.py::test_version_engine_and_platform_are_told",
        when="joints are driven",
    ),
    Difference(
        "Scenes are V-REP's own files, MJCF or URDF.",
        "A script that asks for `robot.ttt` where there is none gets `robot.xml`.",
        "tests/conformance/test_simulation_functions.py::test_a_name_of_the_originals_format_means_the_same_stem_in_ours",
        "simxLoadScene simxLoadModel",
    ),
    Difference(
        "Nothing listens beyond this machine",
        "unless `--listen` says so.",
        _ZENOH + "test_the_ready_line_names_endpoints_realm_and_scene_and_is_all_of_stdout",
        when="another host",
    ),
    Difference(
        "Orientations of `simxGetObjectGroupData`",
        "(types 11 and 12) are quaternions, as the manual says. V-REP sent Euler angles and an undefined number.",
        _OBJECTS + "test_group_data_agrees_with_the_single_functions",
        "simxGetObjectGroupData",
        when="quaternions of group data",
    ),
    Difference(
        "Split modes work like their whole counterparts.",
        "Pieces were a matter of the original's transport.",
        _MODES + "test_oneshot_split_behaves_like_oneshot",
        when=NEVER,
    ),
    Difference(
        "Signals outlive stop and start",
        "when a client set them; those that a child script set go with the script.",
        _SIGNALS + "test_signals_of_a_client_outlive_stop_and_start",
        "simxSetFloatSignal simxSetIntegerSignal simxSetStringSignal simxAppendStringSignal",
        when="signals and a stop",
    ),
    # The README does not contain the differences from here on.
    Difference(
        "A blocking script call returns its own outputs.",
        "V-REP gave those of a oneshot call of the same function that was still on its way.",
        _SURPRISES + "test_04_a_blocking_script_call_returns_its_own_outputs",
        "simxCallScriptFunction",
        when="script calls in two modes",
    ),
    Difference(
        "A blocking call while communication is paused answers 3 at once.",
        "No reply can come, so nothing is waited for; the call is sent with the batch, as in V-REP.",
        _MODES + "test_a_blocking_call_while_paused_times_out_at_once_and_is_sent_with_the_batch",
        "simxPauseCommunication",
        when="a blocking call while paused",
    ),
    Difference(
        "A refused connection with doNotReconnectOnceDisconnected is −1 at once.",
        "V-REP let the whole time-out pass, though it tried only once. Without that argument both keep trying.",
        _ZENOH + "test_nothing_there_is_minus_1_at_once_with_the_way_out",
        "simxStart",
        when=NEVER,
    ),
    Difference(
        "Host names resolve,",
        "`localhost` too; V-REP took dotted addresses only.",
        _ZENOH + "test_host_names_other_loopback_addresses_and_bytes_connect",
        "simxStart",
        when=NEVER,
    ),
    Difference(
        "A lost connection is taken up again",
        "when the server is back, unless doNotReconnectOnceDisconnected says not to, and its streams are armed again. "
        "V-REP's Python binding could not, because of a dangling pointer, and forgot its streams.",
        _ZENOH + "test_a_killed_server_is_noticed_and_a_new_one_is_found_again",
        "simxStart simxGetConnectionId",
        when=NEVER,
    ),
    Difference(
        "Streaming again with equal arguments changes nothing.",
        "The stream continues; V-REP started it again. Scripts that read with streaming each time cost nothing.",
        "tests/conformance/test_mode_rules.py::test_streaming_again_with_equal_arguments_leaves_the_stream_as_it_is",
        when=NEVER,
    ),
    Difference(
        "A stream of simxReadStringStream gives (0, empty) between data",
        "from its first answer on; a value is never missing while the stream runs.",
        _MODES + "test_read_string_stream_loses_nothing_and_gives_empty_data_between",
        "simxReadStringStream",
    ),
    Difference(
        "Error texts belong to a client.",
        "V-REP kept one list for each port, in which a client could find those of the one before.",
        _SCRIPTS + "test_errors_are_told_once_oldest_first_at_most_50_and_to_their_own_client",
        "simxGetLastErrors",
        when=NEVER,
    ),
    Difference(
        "Functions without identifying arguments follow the rules of all others.",
        "In V-REP their old replies stayed in the inbox for ever, also after discontinue.",
        "tests/conformance/test_mode_rules.py::test_commands_without_a_key_are_forgotten_after_discontinue_like_all_others",
        "simxGetLastErrors simxGetObjectSelection simxCreateDummy simxCloseScene",
        when="an end of a stream",
    ),
    Difference(
        "Mode remove works for script calls.",
        "V-REP looked under the key of another function.",
        _SCRIPTS + "test_script_calls_stream_and_their_reply_can_be_removed",
        "simxCallScriptFunction",
        when=NEVER,
    ),
    Difference(
        "A failing set-call in a split mode is told like any other.",
        "In V-REP a reply without data never came back in split modes.",
        "tests/conformance/test_mode_rules.py::test_an_error_in_a_split_mode_is_seen",
        when=NEVER,
    ),
    Difference(
        "The functions for integer signals return their code under all names.",
        "In the newest sim.py three of them returned None.",
        _SIGNALS + "test_getting_an_integer_signal_returns_the_pair_under_both_names",
        "simxSetIntegerSignal simxGetIntegerSignal simxClearIntegerSignal",
        when=NEVER,
    ),
    Difference(
        "Where nothing is detected, vectors are zeros and the handle is −1.",
        "V-REP left them undefined.",
        _SENSORS + "test_a_proximity_sensor_gives_point_object_and_normal_in_its_frame",
        "simxReadProximitySensor simxReadForceSensor",
    ),
    Difference(
        "Stepped mode can be entered on every port.",
        "In V-REP a service had to be enabled for it beforehand.",
        _SURPRISES + "test_07_a_stop_ends_stepped_mode_and_it_must_be_asked_for_again",
        "simxSynchronous",
        when=NEVER,
    ),
    Difference(
        "simxFinish returns when everything sent has been executed.",
        "V-REP slept for half a second and hoped so.",
        _CONNECTION + "test_finish_lets_the_oneshots_before_it_be_executed",
        "simxFinish",
        when=NEVER,
    ),
    Difference(
        "A negative port is the port of its absolute value.",
        "It meant shared memory in V-REP; connections within one machine are as fast without.",
        "tests/server/gateways/zenoh/test_zenoh.py::test_a_negative_port_is_the_port_of_its_absolute_value",
        "simxStart",
        when="a negative port",
    ),
    Difference(
        "An argument of a wrong kind is a TypeError that names function and argument,",
        "not a ctypes.ArgumentError; arrays of one element are taken as numbers everywhere.",
        _MODES + "test_wrong_arguments_name_the_function_and_the_argument",
        when=NEVER,
    ),
    Difference(
        "Names of files at the server may be str.",
        "The original wanted bytes there.",
        _SCRIPTS + "test_a_local_file_lands_under_a_plain_name_at_the_server",
        "simxTransferFile",
        when=NEVER,
    ),
    Difference(
        "The stop takes back what a run loaded, copied, created or removed,",
        "as it does everything else. Handles of what a run added are not given again.",
        "tests/server/editing/test_editing_properties.py::"
        "test_removing_everything_empties_the_scene_in_one_edit_and_stop_brings_it_back",
        "simxLoadModel simxCopyPasteObjects simxCreateDummy simxRemoveObject simxRemoveModel",
        when="changes and a stop",
    ),
    Difference(
        "Models are V-REP's own files, MJCF, URDF, STL, OBJ, COLLADA or PLY;",
        "the name of a missing `.ttm` file means the same stem with such an ending.",
        "tests/server/editing/test_editing_models.py::test_vrep_name_finds_the_model_of_the_same_stem",
        "simxLoadModel simxLoadScene",
    ),
    Difference(
        "Transferred files lie in the workspace,",
        "the only folder a client may touch; the original had one for temporary files.",
        "tests/server/files/test_files.py::test_transferred_file_has_the_same_bytes_whatever_kind_of_name",
        "simxTransferFile simxEraseFile",
    ),
    Difference(
        "A joint on a tendon in force mode cannot be set (code 8);",
        "give it a target. V-REP has no such joints.",
        "tests/server/joints/test_joints_modes.py::test_tendon_with_a_servo_is_a_prismatic_joint",
        "simxSetJointPosition",
        when=NEVER,
    ),
    Difference(
        "Velocities are zero when stopped;",
        "V-REP went on giving the last values of the run.",
        "tests/server/scene/test_frames_poses.py::test_measured_velocity_is_the_difference_of_the_last_two_steps",
        "simxGetObjectVelocity",
        when="a stop",
    ),
    Difference(
        "A proximity sensor does not detect the shape that carries it.",
        "V-REP's models declare that shape undetectable instead; sensors of V-REP's own files do detect it.",
        "tests/server/sensors/test_sensors_proximity_force.py::test_sensor_sees_the_nearest_thing_in_its_own_frame",
        "simxReadProximitySensor",
        when=NEVER,
    ),
    Difference(
        "Convex shapes are solid in collision checks;",
        "one that lies wholly within another collides with it. V-REP compared surfaces.",
        "tests/server/sensors/test_collisions.py::test_a_convex_shape_wholly_within_another_collides_with_it",
        "simxCheckCollision simxReadCollision",
    ),
    Difference(
        "Every console has a different handle;",
        "the original without a window gave all of them 1. Printing to one that never was is an error.",
        "tests/server/parts/test_user_interface_consoles.py::"
        "test_closing_is_never_an_error_and_a_handle_that_never_was_cannot_be_printed_to",
        "simxAuxiliaryConsoleOpen simxAuxiliaryConsolePrint simxAuxiliaryConsoleShow",
    ),
    Difference(
        "Events of custom UIs wait in a queue,",
        "so the second of two quick clicks is not lost; the original kept the last one.",
        "tests/server/parts/test_user_interface_custom_uis.py::test_people_operate_it_and_each_event_is_read_once_in_order",
        "simxGetUIEventButton",
        when=NEVER,
    ),
    Difference(
        "Custom UIs are described in TOML or JSON;",
        "a `.ttb` name means the same stem with such an ending.",
        "tests/server/parts/test_user_interface_custom_uis.py::test_file_becomes_uis_that_are_found_by_name",
        "simxLoadUI",
    ),
    Difference(
        "Predefined assembly is not available (code 8).",
        "V-REP assembled with the handle plus 0x400000 and keepInPlace false; place the object, then set its parent.",
        _OBJECTS + "test_the_assembly_flag_is_8_unless_the_place_is_kept",
        "simxSetObjectParent",
        when="an assembly",
    ),
    Difference(
        "One scene is loaded at a time,",
        "and closing it opens the default scene. V-REP showed another open scene, if there was one.",
        "tests/conformance/test_simulation_functions.py::test_closing_opens_the_default_scene_and_is_8_while_running",
        "simxCloseScene simxLoadScene",
    ),
    Difference(
        "Scenes, models and UIs at the server are loaded from its open folders only:",
        "the workspace, the shipped ones, that of the present scene. A path that leads elsewhere counts by its last "
        "part alone; what none of them has is code 8. V-REP opened any file.",
        "tests/server/files/test_files.py::test_server_side_paths_outside_are_refused",
        "simxLoadScene simxLoadModel simxLoadUI",
    ),
    Difference(
        "Numbers that are not finite in single precision are refused (code 8);",
        "V-REP took NaN and infinity.",
        _OBJECTS + "test_numbers_that_are_not_finite_are_8_and_change_nothing",
        when=NEVER,
    ),
    Difference(
        "Calls are sent at once;",
        "commThreadCycleInMs means nothing. So two oneshot calls of a key are both executed, unless communication is "
        "paused; of those within one of V-REP's cycles only the last was.",
        _SURPRISES + "test_03_without_a_pause_every_call_is_sent_at_once_and_executed",
        "simxStart",
        when="a loop without a pause",
    ),
    Difference(
        "A loop that calls faster than the server executes is slowed to its pace.",
        "After 200 unanswered messages the next call waits for an answer, so that nothing acts later and later.",
        "tests/server/service/test_server_loop.py::test_a_loop_without_a_pause_runs_at_the_servers_pace_and_builds_no_backlog",
        when="a loop without a pause",
    ),
    Difference(
        "A stream of simxGetLastErrors tells each text once and loses none,",
        "up to 50 unread ones. In V-REP the next, mostly empty reply replaced texts that had not been read.",
        "tests/server/parts/test_parameters.py::test_streamed_errors_are_each_told_once_however_late_they_are_read",
        "simxGetLastErrors",
        when=NEVER,
    ),
    Difference(
        "Files above 64 MiB do not travel (code 32).",
        "Put them into the server's workspace yourself.",
        "tests/server/files/test_files.py::test_file_that_is_too_large_stays_here",
        "simxTransferFile simxLoadScene simxLoadModel simxLoadUI",
        when=NEVER,
    ),
    Difference(
        "A timeOut of 0 or less for simxTransferFile means that of all blocking calls.",
        "V-REP took the number as it was, so that nothing was waited for.",
        "tests/server/files/test_files.py::test_time_out_of_the_transfer_is_the_one_that_was_given",
        "simxTransferFile",
    ),
    Difference(
        "A blocking call answers 3 at once when no server can come any more:",
        "the connection was lost, or never made, and is not to be taken up again. V-REP let the time-out pass.",
        "tests/server/service/test_server_loop.py::test_without_reconnection_calls_answer_at_once_that_there_is_no_value",
        when=NEVER,
    ),
    Difference(
        "With several stepped clients a trigger answers when all have triggered.",
        "V-REP answered at once. A script with two stepped clients triggers one of them from another thread.",
        "tests/server/service/test_server_loop.py::test_all_stepped_clients_must_trigger",
        "simxSynchronousTrigger",
        when="several stepped clients",
    ),
    Difference(
        "simxCheckDistance gives 0 while distance handling is switched off, and 8 when there is nothing to measure.",
        "V-REP answered both with success and an undefined number.",
        "tests/server/sensors/test_collisions.py::test_switched_off_handling_answers_success",
        "simxCheckDistance",
    ),
    Difference(
        "While stopped, and before the first simulation step, images show the scene as it is.",
        "V-REP gave the background colour and depth 1.",
        "tests/server/handlers/test_handlers_vision.py::test_image_is_rgb_or_grey_bytes_without_a_running_simulation",
        "simxGetVisionSensorImage simxGetVisionSensorDepthBuffer",
        when=NEVER,
    ),
    Difference(
        "With vision sensors switched off (boolean parameter 10) images are the background.",
        "In V-REP the last image stayed. simxReadVisionSensor is 8 in both.",
        "tests/server/sensors/test_sensors_vision.py::test_switched_off_handling_shows_the_background",
        "simxGetVisionSensorImage simxGetVisionSensorDepthBuffer",
        when="cameras are switched off",
    ),
    Difference(
        "Any options but 0 mean a grey image.",
        "With 2 and the like V-REP sent colours, of which its Python binding took the first third.",
        _SENSORS + "test_a_grey_image_is_the_mean_of_the_colours",
        "simxGetVisionSensorImage",
        when="a grey image",
    ),
    Difference(
        "An image given to a sensor with external input goes with the stop, and its statistics last until then.",
        "In V-REP the image stayed after the stop, and the statistics went with the next simulation step.",
        "tests/server/sensors/test_sensors_vision.py::test_external_input_stays_and_nothing_is_rendered",
        "simxSetVisionSensorImage simxReadVisionSensor",
    ),
    Difference(
        "What cameras do not see, proximity sensors do not detect",
        "(MuJoCo's geom groups from 3 on, what is wholly transparent), nor what is annotated as not detectable. "
        "V-REP's shapes say both separately, and so do the shapes of V-REP files.",
        "tests/server/sensors/test_sensors_proximity_force.py::test_what_cameras_do_not_see_is_not_detected",
        "simxReadProximitySensor",
    ),
    Difference(
        "Switches of what needs a window read False, may be switched off, and are 8 when switched on.",
        "V-REP without a window answered 8 to all of it.",
        "tests/server/parts/test_parameters.py::test_what_needs_a_window_is_off_and_says_so",
        "simxGetBooleanParameter simxSetBooleanParameter",
    ),
    Difference(
        "Parameters of V-REP's drawing and machinery read as they were set and change nothing:",
        "fog, background and ambient light, video, the window, threads, warnings and so on. The colour of the fog is "
        "the background of images.",
        "tests/server/parts/test_parameters.py::test_settings_of_vreps_own_drawing_and_machinery_are_kept",
        "simxGetIntegerParameter simxSetIntegerParameter simxGetFloatingParameter simxSetFloatingParameter "
        "simxGetStringParameter simxGetArrayParameter simxSetArrayParameter",
        when="parameters but the time step",
    ),
    Difference(
        "Parameters of objects that mean nothing in MuJoCo read as they were set and change nothing;",
        "those of textures, edges and views are such. The log says so once. A part of the world has no mass and mask.",
        "tests/server/handlers/test_object_parameters.py::"
        "test_what_has_no_effect_keeps_its_value_until_the_stop_and_is_told_once",
        "simxGetObjectFloatParameter simxSetObjectFloatParameter simxGetObjectIntParameter simxSetObjectIntParameter",
        when="parameters of objects but common ones",
    ),
    Difference(
        "Random numbers are the same in every run of the server.",
        "So a script that takes them from there does the same again.",
        "tests/server/parts/test_parameters.py::test_random_numbers_are_the_same_in_every_server",
        "simxGetFloatingParameter simxGetArrayParameter",
        when="random parameters",
    ),
    Difference(
        "A target drives a joint that has no annotation,",
        "whose motor and control loop are switched as the target needs it. V-REP's joints say in their file how they "
        "are driven; so do annotated ones.",
        "tests/server/joints/test_joints_modes.py::test_joint_without_actuator_and_annotation_is_free_until_a_target_drives_it",
        "simxSetJointTargetPosition simxSetJointTargetVelocity",
        when=NEVER,
    ),
    Difference(
        "The first simxGetJointForce of a run may be that of the last physics step,",
        "in scenes without position controllers. All later ones are means over the simulation step, as in V-REP.",
        "tests/server/joints/test_joints_modes.py::test_force_is_the_motors_mean_over_the_step",
        "simxGetJointForce",
    ),
    Difference(
        "A script goes on after an error in a function that a client called.",
        "V-REP 4.2 ended the script.",
        _SCRIPTS + "test_every_trouble_in_a_script_call_is_8_with_a_text",
        "simxCallScriptFunction",
        when=NEVER,
    ),
    Difference(
        "Signals, consoles, dialogs and custom UIs have an upper number and length (code 8 above it).",
        "V-REP took more until its memory was full.",
        "tests/server/parts/test_signals.py::test_too_many_or_too_large_signals_are_refused",
        "simxSetFloatSignal simxSetIntegerSignal simxSetStringSignal simxAppendStringSignal simxAuxiliaryConsoleOpen "
        "simxDisplayDialog simxLoadUI",
        when=NEVER,
    ),
    Difference(
        "Dialogs and custom UIs need no window:",
        "any program that looks at the simulation sees, answers and operates them.",
        "tests/server/parts/test_user_interface_dialogs.py::test_another_client_sees_and_answers_a_dialog_through_the_add_on",
        "simxDisplayDialog simxLoadUI",
    ),
    Difference(
        "There are limits:",
        "4096 streams of a client (more are executed once), lists of a million items, texts of a million characters, "
        "64 MiB of binary data. Larger values give code 8.",
        _CONNECTION + "test_what_is_beyond_the_limits_is_an_error_and_the_server_goes_on",
        when=NEVER,
    ),
    Difference(
        "All render modes of a vision sensor (integer parameter 1017) but 2, handles, draw the same colours.",
        "V-REP's 1 drew auxiliary channels, its others used other renderers.",
        "tests/server/sensors/test_sensors_handles.py::test_every_mode_but_2_is_kept_and_draws_colours",
        "simxSetObjectIntParameter",
        when="a render mode",
    ),
    Difference(
        "A link of a URDF is one shape, called as the link.",
        "V-REP's importer made two of it, `NAME_respondable` and `NAME_visual`; both names find it. A fixed joint is "
        "not a force sensor. A robot is free if it stands on moving links; V-REP's was if its base had an inertia.",
        "tests/server/scene/formats/test_urdf.py::test_names_of_vreps_importer_find_the_link",
        when=NEVER,
    ),
    Difference(
        "A client that asks the simulator to exit ends it when the other clients have left.",
        "V-REP ended at once, for all of them.",
        "tests/server/app/test_exit_request.py::test_a_client_that_asks_for_the_end_does_not_end_it_for_the_others",
        "simxSetBooleanParameter",
        when=NEVER,
    ),
)


def numbers_of(names: Iterable[str]) -> list[int]:
    """Return the numbers of the differences that affect a function, given all its names."""
    wanted = set(names)
    return [n for n, each in enumerate(DIFFERENCES, 1) if wanted & set(each.commands.split())]


def as_list() -> str:
    """Return all of them as a numbered list in Markdown, each with its test."""
    return "\n".join(f"{n}. {each.sentence} `{each.test}`" for n, each in enumerate(DIFFERENCES, 1))


def for_readme() -> str:
    """Return those of the README as a list in Markdown."""
    return "\n".join(f"- {DIFFERENCES[number - 1].sentence}" for number in IN_README)
