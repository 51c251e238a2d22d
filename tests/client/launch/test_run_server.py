"""simx-run --server: a server of the script's own, there before its first line and gone after its last."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from launching import environment, python, simx_run, write_script

pytestmark = pytest.mark.slow

STAND_IN = """\
import json, os, signal, sys, threading
gone = threading.Event()
signal.signal(signal.SIGTERM, lambda number, frame: gone.set())
with open('server.json', 'w') as file:
    json.dump({'arguments': sys.argv[1:], 'config': os.environ.get('SIMX_CONFIG', '')}, file)
print('starting', flush=True)
print('ready tcp/127.0.0.1:4001 realm=tutorial', flush=True)
for line in range(5000):
    print('much more output than a pipe holds', line, flush=True)
gone.wait()
os.rename('server.json', 'stopped.json')
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a simx_server that is a stand-in, and is found first."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    (tmp_path / "simx_server").mkdir()
    (tmp_path / "simx_server" / "__main__.py").write_text(STAND_IN)
    (tmp_path / "simx_server" / "__init__.py").write_text("")
    return tmp_path


def test_server_is_ready_before_and_stopped_after(folder: Path) -> None:
    text = (
        "import json, os\nprint(json.load(open('server.json'))['arguments'], os.environ['SIMX_REDIRECT'])\n"
    )
    flags = ("--server", "scene.xml", "--server-args", "--speed max --viewer")
    finished = simx_run(folder, text, flags=flags, start=python)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout == (
        "['scene.xml', '--port', '0', '--no-script-ports', '--speed', 'max', '--viewer', '--until-eof'] "
        "*=127.0.0.1:4001\n"
    )
    assert (folder / "stopped.json").exists()


def test_scene_beside_the_script_is_found_from_another_folder(folder: Path) -> None:
    (folder / "project").mkdir()
    (folder / "project" / "lab.ttt").write_bytes(b"VREP")
    write_script(folder / "project", "import json\nprint(json.load(open('server.json'))['arguments'][0])\n")
    for scene, given in (("lab.ttt", str(Path("project", "lab.ttt"))), ("other.ttt", "other.ttt")):
        finished = subprocess.run(
            [sys.executable, "-m", "simx_client.launch.run", "--server", scene, "project/script.py"],
            cwd=folder, env=environment(), capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
        assert finished.stdout == f"{given}\n", finished.stderr


@pytest.mark.parametrize(
    ("more", "kept"), [((), ""), (("--server-args", "--config s.json5"), "client.json5")]
)
def test_config_of_a_client_is_not_the_servers_and_the_scripts_only_if_the_server_has_its_own(
    folder: Path, monkeypatch: pytest.MonkeyPatch, more: tuple[str, ...], kept: str
) -> None:
    """A server that asks for no login does not let in who has one."""
    monkeypatch.setenv("SIMX_CONFIG", "client.json5")
    text = "import json, os\nprint([json.load(open('server.json'))['config'], os.environ.get('SIMX_CONFIG', '')])"
    finished = simx_run(folder, text, flags=("-v", "--server", "scene.xml", *more), start=python)
    assert finished.stdout == f"{['', kept]}\n", finished.stderr
    assert ("SIMX_CONFIG" in finished.stderr) == (not kept)


def test_module_in_the_working_folder_takes_no_place_of_the_servers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is the server's workspace, where clients may write."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    (tmp_path / "mujoco.py").write_text("open('evil', 'w').close()\n")
    (tmp_path / "simx_server").mkdir()
    (tmp_path / "simx_server" / "__main__.py").write_text("open('evil', 'w').close()\n")
    finished = simx_run(tmp_path, "print('done')", flags=("--server", "two_link_arm"), start=python)
    assert finished.stdout == "done\n", finished.stderr
    assert not (tmp_path / "evil").exists()


@pytest.mark.parametrize(
    ("text", "code"), [("raise SystemExit(7)", 7), ("1 / 0", 1), ("raise KeyboardInterrupt", 130), ("", 0)]
)
def test_exit_code_is_the_scripts(folder: Path, text: str, code: int) -> None:
    assert simx_run(folder, text, flags=("--server", "scene.xml"), start=python).returncode == code
    assert (folder / "stopped.json").exists()


def test_threads_and_exit_functions_of_the_script_still_have_their_server(folder: Path) -> None:
    text = """
        import atexit, os, threading
        def check(who):
            print(who, os.path.exists('server.json'), os.path.exists('stopped.json'))
        atexit.register(check, 'exit function')
        main_is_over = threading.Event()
        threading.Thread(target=lambda: (threading.main_thread().join(), check('thread'))).start()
    """
    finished = simx_run(folder, text, flags=("--server", "scene.xml"), start=python)
    assert finished.stdout.splitlines() == ["thread True False", "exit function True False"]
    assert (folder / "stopped.json").exists()


def test_ending_the_launcher_ends_the_server(folder: Path) -> None:
    write_script(folder, "print('running', flush=True)\nimport threading\nthreading.Event().wait()\n")
    command = [sys.executable, "-m", "simx_client", "run", "--server", "scene.xml", "script.py"]
    with subprocess.Popen(
        command, cwd=folder, env=environment(), stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "running\n"
        process.terminate()
        process.communicate(timeout=30)
    assert process.returncode == (-signal.SIGTERM if os.name == "posix" else 1)
    assert (folder / "stopped.json").exists()


def test_a_server_that_fails_to_start_is_said_and_the_script_not_run(folder: Path) -> None:
    (folder / "simx_server" / "__main__.py").write_text(
        "import sys\nsys.stderr.write('no such scene\\n')\nsys.exit(2)\n"
    )
    finished = simx_run(folder, "print('script')", flags=("--server", "none.xml"), start=python)
    assert finished.returncode == 1
    assert finished.stdout == ""
    assert finished.stderr == (
        "no such scene\nsimx-run: simx-server ended with code 2 before it was ready; see above for why\n"
    )


def test_a_server_that_is_never_ready_is_given_up_and_stopped(folder: Path) -> None:
    (folder / "simx_server" / "__main__.py").write_text(STAND_IN.replace("ready ", "waiting "))
    flags = ("--server", "scene.xml", "--server-timeout", "1")
    finished = simx_run(folder, "print('script')", flags=flags, start=python)
    assert finished.returncode == 1
    assert finished.stdout == ""
    assert "not ready within 1 s" in finished.stderr
    assert "--server-timeout" in finished.stderr


def test_a_server_that_ends_early_is_mentioned(folder: Path) -> None:
    (folder / "simx_server" / "__main__.py").write_text(
        "import os\nprint('ready', flush=True)\nopen('over', 'w').close()\nos._exit(3)\n"
    )
    text = """
        import json, os, subprocess, sys
        while not os.path.exists('over'): pass
        # the launcher's only child: wait until it is gone without reaping it
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOWAIT)
    """
    finished = simx_run(folder, text, flags=("--server", "scene.xml"), start=python)
    assert finished.returncode == 0
    assert "simx-server had already exited with code 3" in finished.stderr
