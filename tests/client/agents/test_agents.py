"""``simx mcp``: an agent, by the protocol's own client over stdio, loads a scene, steps, looks and goes back."""

from __future__ import annotations

import base64
import os
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from processes import PENDULUM, ROOT

from simx_client.agents.answers import MOST_PIXELS, MOST_TEXT, Folder, Refused, limited, small_png
from simx_client.agents.programs import run_program
from simx_client.agents.session import Session
from simx_client.errors import SimxError
from simx_client.protocol.cli.installing import extra_line

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]

CAMERA = '<camera name="eye" pos="0 -2 1" xyaxes="1 0 0 0 0 1" resolution="32 24"/><body name="arm"'
Ask = Callable[..., Awaitable[tuple[bool, Any]]]


def with_agent(folder: Path, work: Callable[[Any, Ask], Awaitable[None]], *words: str) -> None:
    """Run an agent against ``simx mcp``."""
    pytest.importorskip("mcp", reason=extra_line("mcp"))
    import anyio
    from mcp.client import Client  # pyright: ignore[reportMissingImports]
    from mcp.client.stdio import StdioServerParameters  # pyright: ignore[reportMissingImports]

    started = StdioServerParameters(
        command=sys.executable,
        args=["-m", "simx_client", "mcp", "--folder", str(folder), *words],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])},
    )

    async def session() -> None:
        async with Client(started) as client:

            async def ask(tool: str, **arguments: Any) -> tuple[bool, Any]:
                result = await client.call_tool(tool, arguments)
                (content,) = result.content
                return bool(result.is_error), getattr(content, "text", None) or content

            with anyio.fail_after(280):
                await work(client, ask)

    anyio.run(session)


def test_an_agent_loads_steps_looks_and_goes_back(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(PENDULUM.replace('<body name="arm"', CAMERA))
    (tmp_path / "script.py").write_text('import vrep\nvrep.simxGetObjectHandle(0, "elbow", 65536)\n')

    async def work(client: Any, ask: Ask) -> None:
        names = {tool.name for tool in (await client.list_tools()).tools}
        assert {"load", "tree", "step", "call", "image", "past", "go_on_from", "replay", "check"} <= names
        assert not names & {"run", "compare"}, "code needs --allow-code"
        assert await ask("step") == (True, "Error executing tool step: no scene is loaded; call load first")
        failed, text = await ask("load", scene="../scene.xml")
        assert failed
        assert "is outside the folder" in text
        failed, text = await ask("load", scene="scene.xml", record="run.simxlog")
        assert (failed, "cameras: eye" in text) == (False, True)
        _, text = await ask("tree")
        assert {line.split(maxsplit=1)[1] for line in text.splitlines()} == {
            "hinge  joint",
            "arm  shape",
            "eye  vision sensor",
        }
        assert await ask("call", function="simxSetJointTargetVelocity", arguments=["hinge", 1.0]) == (
            False,
            "{}",
        )
        _, text = await ask("step", count=10)
        assert "the time is 0.500 s, the simulation is running" in text
        _, before = await ask("call", function="simxGetJointPosition", arguments=["hinge"])
        assert float(before.partition(":")[2].strip(" }")) == pytest.approx(0.5, abs=0.05)
        failed, text = await ask("call", function="simxGetJointPosition", arguments=["hing"])
        assert (failed, "did you mean 'hinge'" in text) == (True, True)
        failed, text = await ask("call", function="simxTransferFile", arguments=["/etc/hosts", "x"])
        assert (failed, "moves files of this computer" in text) == (True, True)
        failed, image = await ask("image", camera="eye")
        assert base64.b64decode(image.data).startswith(b"\x89PNG")
        _, text = await ask("past", step=5)
        assert "joints: hinge" in text
        _, text = await ask("go_on_from", step=5)
        assert "paused at step 5, 0.250 s" in text
        await ask("step", count=5)
        assert (await ask("call", function="simxGetJointPosition", arguments=["hinge"]))[1] == before
        _, text = await ask("functions", words="joint position target")
        assert "simxSetJointTargetPosition takes jointHandle" in text
        _, text = await ask("check", script="script.py", scene="scene.xml")
        assert "no object 'elbow'" in text
        await ask("load", scene="scene.xml")  # ends the recording
        _, text = await ask("replay", recording="run.simxlog")
        assert "exit code 0 (the states are equal)" in text

    with_agent(tmp_path, work)


def test_programs_run_only_where_code_is_allowed(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(PENDULUM)
    (tmp_path / "program.py").write_text("print('it ran')\n")

    async def work(client: Any, ask: Ask) -> None:
        failed, text = await ask("run", program="program.py", scene="scene.xml")
        assert (failed, "it ran" in text, text.startswith("exit code 0")) == (False, True, True)
        failed, text = await ask("run", program="/etc/hosts", scene="scene.xml")
        assert (failed, "outside the folder" in text) == (True, True)

    with_agent(tmp_path, work, "--allow-code")


def test_a_program_ends_in_time_with_its_children(tmp_path: Path) -> None:
    (tmp_path / "endless.py").write_text(
        "import subprocess, sys\nsubprocess.run([sys.executable, '-c', 'import time; time.sleep(1000)'])\n"
    )
    with pytest.raises(Refused, match="it did not end within 2 s"):
        run_program("endless", folder=tmp_path, timeout=2)


def test_a_check_runs_no_module_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "argparse.py").write_text("raise SystemExit('a module of the folder ran')\n")
    (tmp_path / "script.py").write_text(
        "import vrep\nvrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)\n"
    )
    session = Session(Folder(tmp_path), tmp_path)
    assert "exit code 0" in session.check("script.py")


def test_an_agent_reads_why_a_call_was_refused_each_time(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(PENDULUM)
    session = Session(Folder(tmp_path), tmp_path)
    try:
        session.load("scene.xml")
        for _ in range(2):
            with pytest.raises(SimxError, match="no model 'nothing'"):
                session.call("simxLoadModel", ["nothing", 0])
    finally:
        session.close()


def test_answers_are_bounded() -> None:
    import numpy as np

    text = limited("a" * 1_000_000)
    assert len(text) < MOST_TEXT + 100
    assert "characters are left out" in text
    image = small_png(np.zeros((3000, 2000, 3), np.uint8), is_colour=True)
    assert max(int.from_bytes(image[place : place + 4], "big") for place in (16, 20)) <= MOST_PIXELS


def test_files_are_those_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "inside").mkdir()
    (tmp_path / "outside.xml").touch()
    (tmp_path / "inside" / "link.xml").symlink_to(tmp_path / "outside.xml")
    folder = Folder(tmp_path / "inside")
    for text in ("../outside.xml", str(tmp_path / "outside.xml"), "link.xml"):
        with pytest.raises(Refused, match="outside the folder"):
            folder.scene(text)
    assert folder.scene("ur5") == "ur5", "a shipped scene"
    for text in ("menagerie:spot", "missing.xml"):
        with pytest.raises(Refused, match="there is no file"):
            folder.scene(text)
    with pytest.raises(Refused, match="cannot be a new file"):
        Folder(tmp_path).file("outside.xml", is_new=True)
