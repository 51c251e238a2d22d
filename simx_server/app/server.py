"""Compose the server: settings in, a serving process out. No other module knows all the parts.

The parts that only some flags need are imported by the functions that use them: most servers start without.
"""

from __future__ import annotations

import gc
import logging
import os
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE, INCOMPLETE, INTERRUPTED
from simx_client.protocol.roster import noted
from simx_server.errors import CommandError, StartError
from simx_server.files.library import DEFAULT_SCENE, find_scene
from simx_server.gateways.descriptors import raise_limit
from simx_server.kinematics.searching import Searching
from simx_server.processes import heap
from simx_server.scene.trial.helper import Helper
from simx_server.sensors.opengl.backend import Probe
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.service.ending import Ending
from simx_server.service.loop import ServerLoop
from simx_server.service.service import Service
from simx_server.service.warm_up import wait_until_warm
from simx_server.settings.settings import OMPL, Settings
from simx_server.simulation.simulation import SimulationState
from simx_server.world.world import World

from .building import build_world
from .scene_sources import sources_of
from .serving import Gateways, add_viewers, add_watchers, make_service, open_gateways

if TYPE_CHECKING:
    from simx_server.history.succession import Inheritance
    from simx_server.recording import Recorder

logger = logging.getLogger(__name__)

SWITCH_INTERVAL = 0.001
"""Seconds after which a thread that computes in Python releases the interpreter. With Python's own 0.005, a message of
one client needs that long to get past the physics thread while others keep it busy; shorter times cost too much.
"""


def open_world(
    settings: Settings,
    stack: ExitStack,
    prepare: Callable[[World, Path], None] | None = None,
    rendering: RenderThread | None = None,
) -> World:
    """Return a world with its scene, ready to start; ``stack`` closes it.

    Args:
        prepare: called with the world and this file before the file is loaded.
        rendering: renders the images; its owner closes it.

    Raises:
        CommandError: the scene cannot be used.
        StartError: the planner is not installed, or messages of ROS 2 cannot be used.
    """
    if settings.planner == OMPL:
        from simx_server.kinematics.planning.ompl_planner import missing

        if problem := missing():
            raise StartError(problem)
    if rendering is None:
        rendering = RenderThread(limits=settings.limits)
        stack.callback(rendering.close)
    scene = find_scene(settings.scene or DEFAULT_SCENE)
    world = build_world(
        rendering,
        workspace=settings.workspace,
        limits=settings.limits,
        sources=sources_of(settings),
        own_scene=scene.resolve(),
        allows_code=settings.allow_code,
        allows_machine=settings.allow_machine,
        needs_seccomp=not settings.unconfined_scripts,
        tries_all=settings.check_files,
        arguments=settings.arguments,
        searching=Searching(settings.seed, uses_ompl=settings.planner == OMPL),
    )
    stack.callback(world.trials.close)
    stack.callback(world.scripts.close)
    if settings.command_server:
        from simx_server.editing.command_server import CommandServer

        world.simulation.parts.attach(CommandServer(world))
    if settings.ros2_messages:
        from simx_server.ros2_messages import read_packages

        world.ros2_topics.add_types(read_packages(settings.ros2_messages))
    if prepare is not None:
        prepare(world, scene)
    world.simulation.load(scene)
    if settings.time_step is not None:
        world.simulation.time_step = settings.time_step
    return world


def serve(settings: Settings, probe: Probe | None = None, helper: Helper | None = None) -> int:
    """Run a server until it is requested to end. Returns the process's exit code.

    Args:
        probe: tries OpenGL back ends, see `choose_backend`.
        helper: makes trials of clients' files; None: one is started with the first.
    """
    if settings.view is not None:
        from simx_server.viewer.launching import missing

        if problem := missing():
            logger.error("%s", problem)
            return FAILURE
    rendering = RenderThread(probe=probe, limits=settings.limits)
    try:
        if settings.replay is not None:
            exit_code = _replay(settings.replay, settings, rendering)
        elif settings.save_mjcf is not None:
            exit_code = _save_mjcf(settings.save_mjcf, settings)
        elif settings.convert is not None:
            exit_code = _convert(settings.convert, settings)
        elif settings.snapshot is not None:
            exit_code = _image(settings.snapshot, settings, rendering)
        elif settings.save is not None:
            exit_code = _save(settings.save, settings, rendering)
        else:
            exit_code = _serve(settings, rendering, helper)
    finally:
        rendering.close()
    if rendering.is_stuck:
        # Python would wait for that thread, and a driver's clean-up for the driver.
        logging.shutdown()
        sys.stdout.flush()
        os._exit(exit_code)
    return exit_code


def _serve(settings: Settings, rendering: RenderThread, helper: Helper | None) -> int:
    with ExitStack() as stack:
        recorder = page_listener = None
        if settings.view is not None:
            from simx_server.viewer.launching import listen

            try:
                page_listener = stack.enter_context(listen(settings.view, "--view"))
            except OSError as error:
                logger.error("%s", error)
                return FAILURE
        try:
            if settings.record is not None:
                from simx_server.recording import Recorder

                recorder = Recorder(settings.record, settings)
                stack.callback(recorder.close)
            world = open_world(settings, stack, recorder and recorder.watch, rendering)
            if helper is not None:
                world.trials.use(helper)
            attach_outputs(world, settings, stack, recorder.began if recorder else time.time_ns())
        except (CommandError, StartError) as error:
            logger.error("%s", error)
            return FAILURE
        return run_server(world, settings, say_ready, recorder=recorder, page_listener=page_listener)


def serve_child(
    world: World | None,
    settings: Settings,
    ready: Callable[[Gateways, World], None],
    inheritance: Inheritance | None,
    *,
    page_listener: socket.socket | None = None,
    is_one_of_many: bool = True,
) -> int:
    """Run a server in a fork of the process that watches it. Returns the exit code.

    Args:
        world: a copy of the one that was loaded; None: it has to be loaded. It also is for a new recording, which
            notes the files that are read.
        ready: called when clients can reach the server.
        inheritance: where its moments are kept, and from what it continues; None: it keeps none.
    """
    with ExitStack() as stack:
        recorder = None
        try:
            if settings.record is not None:
                from simx_server.recording import Recorder

                goes_on = inheritance is not None and bool(inheritance.ended)
                recorder = Recorder(settings.record, settings, goes_on=goes_on)
                stack.callback(recorder.close)
            if world is None or (recorder is not None and recorder.is_empty):
                world = open_world(settings, stack, recorder and recorder.watch)
            else:
                stack.callback(world.rendering.close)
                if recorder is not None:
                    recorder.follow(world)
            attach_outputs(world, settings, stack, recorder.began if recorder else time.time_ns())
        except (CommandError, StartError) as error:
            logger.error("%s", error)
            return FAILURE
        return run_server(
            world,
            settings,
            ready,
            recorder=recorder,
            page_listener=page_listener,
            is_one_of_many=is_one_of_many,
            inheritance=inheritance,
        )


def attach_outputs(world: World, settings: Settings, stack: ExitStack, began: int) -> None:
    """Attach the requested film, state log and bag; ``stack`` ends them.

    Args:
        ``began``: nanoseconds since 1970, the start of the time in a state log and in a bag.

    Raises:
        CommandError, StartError: they cannot be made.
    """
    if settings.video is not None:
        from simx_server.outputs.filming import Film, Shot

        shot = Shot(world, settings.camera, settings.size)
        stack.callback(Film(world.simulation, settings.video, shot, settings.fps).close)
    if settings.state_log is not None:
        from simx_server.outputs.filming import Shot
        from simx_server.outputs.state_log import StateLog

        shot = Shot(world, settings.camera, settings.size) if settings.camera else None
        stack.callback(StateLog(world, settings.state_log, shot, settings.fps, began=began).close)
    if settings.rosbag is not None:
        from simx_server.gateways.ros2.bag.bag import Bag

        stack.callback(Bag(world, settings.rosbag, drive=settings.ros2_drive, began=began).close)


def _save_mjcf(path: Path, settings: Settings) -> int:
    from simx_server.scene.formats.saving import save_mjcf

    try:
        save_mjcf(find_scene(settings.scene or DEFAULT_SCENE), path, sources_of(settings))
    except CommandError as error:
        logger.error("%s", error)
        return FAILURE
    return DONE


def _convert(folder: Path, settings: Settings) -> int:
    from simx_server.scene.formats.exporting.folder import write_folder

    try:
        write_folder(find_scene(settings.scene or DEFAULT_SCENE), folder, sources_of(settings))
    except CommandError as error:
        logger.error("%s", error)
        return FAILURE
    return DONE


def _image(path: Path, settings: Settings, rendering: RenderThread) -> int:
    from simx_server.outputs.filming import Shot, write_snapshot

    with ExitStack() as stack:
        try:
            world = open_world(settings, stack, rendering=rendering)
            shot = Shot(world, settings.camera, settings.size)
            write_snapshot(world, path, shot, settings.duration)
        except (CommandError, StartError) as error:
            logger.error("%s", error)
            return FAILURE
    return DONE


def _save(path: Path, settings: Settings, rendering: RenderThread) -> int:
    from simx_server.outputs.saving import write_saved

    with ExitStack() as stack:
        try:
            write_saved(open_world(settings, stack, rendering=rendering), path, settings.duration)
        except (CommandError, StartError) as error:
            logger.error("%s", error)
            return FAILURE
    return DONE


def _replay(recording: Path, settings: Settings, rendering: RenderThread) -> int:
    from simx_server.outputs.filming import Moment, Shot
    from simx_server.recording.log_file import LogReader
    from simx_server.recording.opened import Opened
    from simx_server.recording.replayed import Divergence
    from simx_server.recording.replaying import replay

    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-replay-")))
        try:
            opened = Opened(LogReader(recording), folder)
            recorded = opened.settings(settings)
            world = open_world(recorded, stack, lambda world, _: opened.attach(world), rendering)
            attach_outputs(world, settings, stack, opened.began)
            moment = None
            if settings.snapshot is not None:
                shot = Shot(world, settings.camera, settings.size)
                moment = Moment(world, shot, settings.duration)
            outcome = replay(opened, world, recorded.history)
            if moment is not None and settings.snapshot is not None:
                moment.write(settings.snapshot)
            if problem := outcome.problem:
                logger.error("the replay of '%s' is not complete: %s; %s", recording, problem, outcome)
                return INCOMPLETE
            logger.info("the replay of '%s' is equal: %s", recording, outcome)
        except Divergence as problem:
            logger.error("the replay of '%s' differs %s", recording, problem)
            return DIVERGED
        except (CommandError, StartError) as error:
            logger.error("%s", error)
            return FAILURE
    return DONE


def run_server(
    world: World,
    settings: Settings,
    say_ready: Callable[[Gateways, World], None],
    *,
    recorder: Recorder | None = None,
    page_listener: socket.socket | None = None,
    is_one_of_many: bool = False,
    attach: Callable[[World, Service], object] = lambda _world, _service: None,
    is_listed: bool = True,
    inheritance: Inheritance | None = None,
) -> int:
    """Serve one simulation until it is requested to end. Returns the process's exit code.

    Args:
        say_ready: called when clients can reach the server.
        page_listener: the socket of the web viewer; None for no viewer.
        is_one_of_many: save memory: the renderer of a scene with cameras is not made with the first client but when a
            program gets the handle of one of them.
        attach: called before the loop runs, for a gateway that others do not have.
        is_listed: other programs of this user find the server, see `roster`.
        inheritance: where its moments are kept, and from what it continues; None: it keeps none.
    """
    simulation = world.simulation
    service = make_service(world, settings)
    raise_limit()
    heap.keep_together()
    sys.setswitchinterval(SWITCH_INTERVAL)
    history = add_watchers(service, settings, warms_up=not is_one_of_many)
    if settings.record is None:
        world.rendering.warm_on_demand()
    with ExitStack() as beside:
        # The web viewer ends after the gateway: it then notices at once that the server has gone.
        pages = beside.enter_context(ExitStack())
        try:
            gateways = beside.enter_context(open_gateways(world, settings, service))
        except StartError as error:
            logger.error("%s", error)
            return FAILURE
        add_viewers(world, service, history, gateways, has_viewer=page_listener is not None)
        attach(world, service)
        with (
            noted(gateways.zenoh.endpoints if is_listed else ()),
            _ending_by_signal(service.ending),
            service.metrics.log.attached(),
        ):
            recovered = None
            if inheritance is not None:
                from simx_server.history.succession import take_over

                recovered = take_over(service, inheritance, recorder)
            elif recorder is not None:
                recorder.begin(service)
            # Loaded objects stay: without this, a full garbage collection halts the physics for 20 ms.
            gc.collect()
            gc.freeze()
            if settings.start and recovered is None and simulation.state is SimulationState.STOPPED:
                for react in service.watchers.started:
                    react()
                simulation.start()
            if recorder is not None:
                wait_until_warm(world.rendering, lambda: service.ending.has_come)
                recorder.write_out()  # a crash right after the start leaves a recording
            if not service.ending.has_come:
                say_ready(gateways, world)
            heap.give_back()  # loading a large scene leaves half of its memory unused
            if page_listener is not None:
                from simx_server.viewer.launching import page

                ports, arm = gateways.zenoh.ports, settings.operated_arm
                pages.enter_context(page(page_listener, ports, settings.temporary_port, arm))
            ServerLoop(service).run(
                None if settings.duration is None else time.monotonic() + settings.duration
            )
            for react in service.watchers.ending:
                react()
            simulation.stop()
            for react in service.watchers.ended:
                react()
    return DONE


def say_ready(gateways: Gateways, world: World) -> None:
    """Write one line to stdout for people, supervisors and tests."""
    sys.stdout.write(ready_line(gateways, world))
    sys.stdout.flush()


def ready_line(gateways: Gateways, world: World) -> str:
    """Return the line that says where clients can reach a server."""
    endpoints = " ".join(gateways.endpoints)
    return f"ready {endpoints} realm={gateways.zenoh.realm} scene={world.simulation.scene.name}\n"


@contextmanager
def _ending_by_signal(ending: Ending) -> Generator[None]:
    """End the server cleanly on SIGINT and SIGTERM; a second one ends the process at once."""
    has_come = False

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal has_come
        if has_come:
            os._exit(INTERRUPTED)
        has_come = True
        ending.request()

    previous = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
