"""simx-run runs a script as ``python SCRIPT`` would: what it sees, how it ends, what is printed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from launching import environment, output_of, python, simx_run, write_script

from simx_client.launch import run

pytestmark = pytest.mark.slow

SCRIPTS = {
    "what it sees": """
        import sys
        print(sys.argv, sys.path[0], __file__, __name__, __doc__, __spec__, __package__)
        print(sorted(globals()), type(__loader__).__name__, type(__builtins__).__name__)
        print(sys.modules['__main__'].__dict__ is globals())
    """,
    "docstring and future": '''
        """What this is."""
        from __future__ import annotations
        x: nothing = 1
        print(__doc__, __annotations__)
    ''',
    "annotations are evaluated": "x: 1 + 1 = 5\nprint(__annotations__)",
    "coded in latin-1": "# -*- coding: latin-1 -*-\nprint(len('\\xe9'), ascii('\\xe9'))",
    "exit without code": "import sys; sys.exit()",
    "exit with code": "import sys; sys.exit(7)",
    "exit with text": "import sys; sys.exit('the reason')",
    "exit by quit": "quit()",
    "uncaught exception": """
        def inner():
            return 1 / 0
        def outer():
            inner()
        outer()
    """,
    "chained exceptions": """
        def fail():
            try:
                {}['key']
            except KeyError as error:
                raise ValueError('later') from error
        fail()
    """,
    "its own excepthook": """
        import sys
        sys.excepthook = lambda kind, error, traceback: print('caught', kind.__name__, traceback.tb_lineno)
        raise ValueError(5)
    """,
    "error in an imported module": "import broken",
    "missing module": "import no_such_module_at_all",
    "syntax error": "x = (1,\nprint('never')\ny = = 2\n",
    "warning at compile time": "x = 5\nprint('a' is x)\n",
    "deprecation in main": "import warnings\nwarnings.warn('old', DeprecationWarning)\n",
    "end of threads and exit functions": """
        import atexit, threading
        go = threading.Event()
        atexit.register(lambda: print('exit function'))
        threading.Thread(target=lambda: (go.wait(), print('thread'))).start()
        go.set() or print('main') if False else (print('main'), go.set())
    """,
    "pickle of its own class": """
        import pickle
        class Robot: pass
        print(type(pickle.loads(pickle.dumps(Robot()))) is Robot)
    """,
    "processes": """
        import multiprocessing
        def work(x): return x * x
        if __name__ == '__main__':
            with multiprocessing.get_context('fork').Pool(1) as pool:
                print(pool.map(work, [2, 3]))
    """,
}


@pytest.mark.parametrize("script", SCRIPTS)
def test_script_runs_as_under_python(tmp_path: Path, script: str) -> None:
    (tmp_path / "broken.py").write_text("def f():\n    raise OSError('broken')\nf()\n")
    ours = simx_run(tmp_path, SCRIPTS[script], "--flag", "value", "-v", start=python)
    theirs = python(tmp_path, "script.py", "--flag", "value", "-v")
    assert (ours.returncode, ours.stdout) == (theirs.returncode, theirs.stdout)
    assert ours.stderr == theirs.stderr


def test_script_in_another_folder_finds_its_neighbours(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "neighbour.py").write_text("name = 'neighbour'\n")
    write_script(folder, "import sys, neighbour\nprint(neighbour.name, sys.path[0], sys.argv[0])")
    link = tmp_path / "link.py"
    link.symlink_to(folder / "script.py")
    for path in ("project/script.py", "link.py"):
        finished = python(tmp_path, "-m", "simx_client", "run", path)
        assert finished.stdout.split() == ["neighbour", str(folder), path], finished.stderr


def test_what_the_script_logs_is_its_own_business(tmp_path: Path) -> None:
    text = "import logging\nlogging.basicConfig(format='%(message)s')\nlogging.warning('once')\n"
    assert simx_run(tmp_path, text, flags=("-v",)).stderr == "once\n"


def test_ctrl_c_ends_with_130(tmp_path: Path) -> None:
    write_script(tmp_path, "print('running', flush=True)\nimport threading\nthreading.Event().wait()\n")
    command = [sys.executable, "-m", "simx_client", "run", "script.py"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "running\n"
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=30)
    assert process.returncode == 130
    assert stderr.rstrip().endswith("KeyboardInterrupt")
    assert "simx_client" not in stderr


def test_ctrl_c_that_the_script_handles_is_the_scripts(tmp_path: Path) -> None:
    text = "try:\n    raise KeyboardInterrupt\nexcept KeyboardInterrupt:\n    print('handled')\n"
    assert output_of(tmp_path, text) == "handled"


def test_missing_script_is_said_in_one_line(tmp_path: Path) -> None:
    finished = python(tmp_path, "-m", "simx_client", "run", "nowhere.py")
    assert finished.returncode == 2
    assert finished.stderr == (
        "simx-run: cannot open nowhere.py: No such file or directory; name the script's .py file\n"
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "simx-run: name the Python script to run: simx-run robotControl.py; "),
        (("--pace", "free"), "simx-run: name the Python script to run"),
        (
            ("robot.ttt",),
            "simx-run: robot.ttt is a scene; name a script too: simx-run --server robot.ttt SCRIPT",
        ),
        (("robot.c",), "simx-run: robot.c is no Python script; "),
        (
            ("ur5",),
            "simx-run: cannot open ur5: No such file or directory; name the script's .py file, or, if it is a scene: "
            "simx-run --server ur5 SCRIPT",
        ),
    ],
)
def test_what_is_no_script_is_named_for_what_it_is(
    words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run.main(words) == 2
    assert capsys.readouterr().err.startswith(said)


def test_a_flag_behind_the_script_is_said_to_be_the_scripts(tmp_path: Path) -> None:
    finished = simx_run(tmp_path, "import sys\nprint(sys.argv[1:])", "--server", "ur5")
    assert finished.stdout == "['--server', 'ur5']\n"
    assert finished.stderr.startswith(
        "simx-run: --server behind the script goes to the script; write it in front"
    )
    own = simx_run(tmp_path, "import sys\nassert 'server' in sys.argv[1]", "--server", "ur5")
    assert (own.returncode, own.stderr) == (0, ""), "this script has such a flag itself"


def test_help_fits_a_screen_and_names_the_script_first(tmp_path: Path) -> None:
    finished = python(tmp_path, "-m", "simx_client", "run", "--help")
    assert finished.returncode == 0
    assert finished.stdout.startswith("usage: simx-run [options] SCRIPT [ARGS...]")
    assert len(finished.stdout.splitlines()) < 45


def test_client_lists_its_commands(tmp_path: Path) -> None:
    finished = python(tmp_path, "-m", "simx_client", "--help")
    assert "run " in finished.stdout
    assert "shims " in finished.stdout
    assert python(tmp_path, "-m", "simx_client", "walk").returncode == 2


def test_a_childs_environment_has_the_pace_and_nothing_else_of_the_launcher(tmp_path: Path) -> None:
    text = "import os\nprint(sorted(name for name in os.environ if 'SIMX' in name))"
    before = [name for name in os.environ if "SIMX" in name]
    assert before == ["SIMX_CACHE"]  # of the tests
    assert output_of(tmp_path, text) == str([*before, "SIMX_PACE"])
    assert [name for name in os.environ if "SIMX" in name] == before
