"""The simulation of one agent: embedded, in stepped mode, with its past."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, cast

from simx_client.cli.one_call import ask, handle_of
from simx_client.cli.past import answer
from simx_client.cli.values.arguments import WrongUse, command_named, parse, usage
from simx_client.cli.values.formatting import as_record
from simx_client.client import Camera, Client
from simx_client.protocol import constants as c
from simx_client.protocol.commands import BY_NAME, Command, Place

from .answers import Folder, Refused, limited, small_png
from .programs import run_program

MOST_STEPS = 10_000
"""Simulation steps of one request."""

MOST_FUNCTIONS = 30
CALL_TIMEOUT = 60.0
"""Seconds for the answer to a call; the first image starts the renderer."""

HISTORY = 600
"""Simulated seconds of past steps that are kept."""

FILE_ON_CLIENT = 1
"""Bit of the options of functions that load a file."""


class Session:
    """One agent's simulation. One thread at a time."""

    def __init__(self, folder: Folder, workspace: Path, *, allows_code: bool = False) -> None:
        """Start without a simulation. The docstrings of the methods are for the agent.

        Args:
            folder: of scenes, scripts and recordings.
            workspace: a folder for files that the simulation writes.
            allows_code: whether programs may run.
        """
        self.folder, self.allows_code = folder, allows_code
        self._workspace = workspace
        self._client: Client | None = None
        self._scene = ""

    def close(self) -> None:
        """End the simulation."""
        if self._client is not None:
            self._client.close()
            self._client = None

    @property
    def client(self) -> Client:
        """Return the client of the simulation. Raises Refused without one."""
        if self._client is None:
            raise Refused("no scene is loaded; call load first")
        return self._client

    def load(self, scene: str, record: str = "") -> str:
        """Load a scene: the name of a shipped one, such as ur5, or a file (.ttt, .xml, .urdf) in the folder.

        Ends the present simulation. `record`: a new file that records all calls and steps, for replay.
        """
        found = self.folder.scene(scene)
        settings: dict[str, object] = {"history": HISTORY, "workspace": str(self._workspace)}
        if record:
            settings["record"] = str(self.folder.file(record, is_new=True))
        if self.allows_code:
            settings["allow_code"] = True
        self.close()
        client = self._client = Client.embedded(found, timeout=CALL_TIMEOUT, **settings)
        self._scene = found
        ask(client.id, BY_NAME["simxSynchronous"], [True])
        cameras = ", ".join(client.objects(Camera).names) or "none"
        return (
            f"loaded '{scene}': {len(client.objects())} objects; cameras: {cameras}; "
            f"a simulation step is {client.simulation.time_step:g} s; the simulation is stopped, and step starts it"
        )

    def tree(self) -> str:
        """List the objects of the scene: handle, name (indented below its parent), type."""
        group = partial(ask, self.client.id, BY_NAME["simxGetObjectGroupData"])
        handles, _, _, names = group([c.sim_appobj_object_type, 0])
        kinds, parents = (group([c.sim_appobj_object_type, data])[1] for data in (1, 2))
        children: dict[int, list[int]] = {}
        for place, parent in enumerate(parents):
            children.setdefault(parent, []).append(place)

        def lines(parent: int, depth: int) -> Iterator[str]:
            for place in children.get(parent, ()):
                yield f"{handles[place]:5}  {'  ' * depth}{names[place]}  {KINDS.get(kinds[place], 'object')}"
                yield from lines(handles[place], depth + 1)

        return limited("\n".join(lines(-1, 0)))

    def step(self, count: int = 1) -> str:
        """Make simulation steps; start the simulation first if it does not run."""
        if not 1 <= count <= MOST_STEPS:
            raise Refused(f"the number of steps is 1 to {MOST_STEPS}, not {count}")
        simulation = self.client.simulation
        if simulation.state != "running":
            ask(self.client.id, BY_NAME["simxSynchronous"], [True])  # a stop ends the stepped mode
            simulation.start()
        for _ in range(count):
            ask(self.client.id, BY_NAME["simxSynchronousTrigger"], [])
        return f"{count} steps are made; the time is {simulation.time:.3f} s, the simulation is {simulation.state}"

    def call(self, function: str, arguments: list[Any] | None = None) -> str:
        """Call a function of the legacy remote API, such as simxGetObjectPosition with ["cube", -1].

        Leave out client id and operation mode. A name stands for a handle. Returns the results as JSON.
        """
        arguments = arguments or []
        try:
            command = command_named(function)
            self._check(command, arguments)
            words = [_word(each) for each in arguments]
            values = parse(command, words, partial(handle_of, self.client.id))
        except WrongUse as error:
            raise Refused(str(error)) from None
        results = as_record(command, ask(self.client.id, command, values))
        return limited(json.dumps(results))

    def _check(self, command: Command, arguments: Sequence[Any]) -> None:
        """Refuse functions that read or write files of this process. Raises Refused."""
        if command.name in _OF_FILES or (command.place is Place.LOCAL and "ile" in command.name):
            raise Refused(f"{command.name} moves files of this computer; load opens scenes and models")
        if command.loads_file and len(arguments) > 1 and arguments[1] not in (0, "0"):
            raise Refused(f"{command.name} takes options 0 here: files that the simulation finds")

    def functions(self, words: str) -> str:
        """Find functions for `call` by words of their names and descriptions."""
        wanted = words.lower().split()
        found = [
            command
            for command in BY_NAME.values()
            if all(word in f"{command.name} {command.doc}".lower() for word in wanted)
        ]
        lines = [f"{usage(each)}\n  {each.doc.splitlines()[0]}" for each in found[:MOST_FUNCTIONS]]
        if len(found) > MOST_FUNCTIONS:
            lines.append(f"and {len(found) - MOST_FUNCTIONS} more; give more words")
        return limited("\n".join(lines) or "no function has these words; give others")

    def image(self, camera: str, depth: bool = False) -> bytes:
        """Return the image of a vision sensor by its name; with `depth` distances, brighter where nearer."""
        found = self.client.camera(camera)
        if not depth:
            return small_png(found.rgb(), is_colour=True)
        near, far = found.near, found.far
        shade = 255 * (far - found.depth()) / max(far - near, 1e-9)
        return small_png(shade.clip(0, 255).astype("uint8"), is_colour=False)

    def past(self, step: int | None = None) -> str:
        """Show a past simulation step: joints, signals, calls; without a step, the last calls that changed something.

        Steps are counted from 1.
        """
        return limited("\n".join(answer(self.client.id, step)[1]))

    def go_on_from(self, step: int) -> str:
        """Start a new run from the end of a past step; it is paused, and `step` goes on. Later steps are forgotten."""
        return "\n".join(answer(self.client.id, step, go_on=True)[1])

    def replay(self, recording: str) -> str:
        """Replay a recording in the folder, and say whether all states are equal, or where they differ first."""
        path = self.folder.file(recording)
        words = ["--allow-code"] if self.allows_code else []
        code, output = self._own_program("simx_server", "--replay", str(path), *words)
        return f"exit code {code} ({REPLAY_CODES.get(code, 'a failure')})\n{output}"

    def check(self, script: str, scene: str = "") -> str:
        """Say what a script in the folder calls and names, and what is missing here, without running it."""
        words = ["--scene", self.folder.scene(scene)] if scene else []
        code, output = self._own_program("simx_client", "check", str(self.folder.file(script)), *words)
        return f"exit code {code} (0: nothing is missing)\n{output}"

    def run(self, program: str, scene: str) -> str:
        """Run a Python program in the folder against a private simulation of a scene; return its output."""
        path, found = self.folder.file(program), self.folder.scene(scene)
        code, output = run_program(
            "simx_client", "run", "--server", found, str(path), folder=self.folder.path
        )
        return f"exit code {code}\n{output}"

    def compare(self, program: str, scene: str, recorded: str) -> str:
        """Run a program in the folder, and compare its run with a recorded one (NPZ, CSV, .simxlog)."""
        path, found, file = self.folder.file(program), self.folder.scene(scene), self.folder.file(recorded)
        words = [str(path), "--scene", found, "--recorded", str(file)]
        code, output = run_program("simx_client", "compare", *words, folder=self.folder.path)
        return f"exit code {code} (0: equal, 3: they depart)\n{output}"

    def _own_program(self, module: str, *words: str) -> tuple[int, str]:
        """Run a program that imports nothing of the folder; see `run_program`."""
        return run_program(module, *words, folder=self.folder.path, flags=["-P"])


def _word(value: Any) -> str:
    """Return an argument as ``simx call`` takes it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None:
        return "none"
    if isinstance(value, list):
        return ",".join(map(str, cast(list[Any], value)))
    return str(value)


_OF_FILES = frozenset(("simxTransferFile", "simxLoadScene", "simxLoadUI"))

REPLAY_CODES = {0: "the states are equal", 3: "the states differ", 4: "equal as far as the recording goes"}

KINDS = {
    c.sim_object_shape_type: "shape",
    c.sim_object_joint_type: "joint",
    c.sim_object_camera_type: "camera",
    c.sim_object_dummy_type: "dummy",
    c.sim_object_proximitysensor_type: "proximity sensor",
    c.sim_object_visionsensor_type: "vision sensor",
    c.sim_object_forcesensor_type: "force sensor",
    c.sim_object_light_type: "light",
    c.sim_object_graph_type: "graph",
    c.sim_object_path_type: "path",
}
