"""``simx-check`` on programs that call no remote API, or one that is not served: it says so, and ends with 2."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked_programs import check, page_of, texts_of, write


def test_a_program_without_a_remote_call_says_so_and_ends_with_2(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": "import numpy as np\nprint(np.zeros(3))\n"})
    code, record = check(tmp_path / "script.py")
    assert (code, record["is_of_a_remote_api"]) == (2, False)
    assert texts_of(record)[0].startswith("no call of a remote API is found")
    page = page_of(tmp_path / "script.py")
    assert page.endswith("no call of a remote API is found, so there is nothing to check\n")
    assert "nothing is missing" not in page
    assert "no problem found" not in page


@pytest.mark.parametrize(
    "text",
    [
        "import vrep\nprint(vrep)\n",
        "class R:\n  def simxStart(self): pass\nR().simxStart()\n",
        "import vrep\n# vrep.simxStart()\n",
        "",
    ],
)
def test_a_program_that_only_looks_like_it_has_no_remote_call(tmp_path: Path, text: str) -> None:
    write(tmp_path, {"script.py": text})
    assert check(tmp_path / "script.py")[0] == 2


def test_a_wrapper_that_is_not_installed_is_named_as_the_reason(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": "from surely_not_installed import Robot\nRobot().simxStart(3)\n"})
    code, record = check(tmp_path / "script.py")
    assert code == 2
    assert texts_of(record)[0].endswith(", or install surely_not_installed, if the calls are in there")


def test_a_function_that_is_passed_on_counts(tmp_path: Path) -> None:
    text = (
        "import vrep, threading\nthreading.Thread(target=vrep.simxStart, args=('', 1, 1, 1, 1, 5)).start()\n"
    )
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py")
    assert (code, list(record["functions"])) == (0, ["simxStart"])


def test_a_b0_program_is_recognised_and_its_calls_are_not_taken_for_legacy_ones(tmp_path: Path) -> None:
    text = """
        import b0RemoteApi
        with b0RemoteApi.RemoteApiClient('b0_python', 'b0RemoteApi') as client:
            handle = client.simxGetObjectHandle('it', client.simxServiceCall())
            client.simxStartSimulation(client.simxDefaultPublisher())
        """
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py")
    assert (code, record["functions"], record["unknown_functions"]) == (2, {}, [])
    assert "B0-based remote API" in texts_of(record)[0]
