"""simx-run --server: every port that a script connects to leads to its private server."""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import output_of, simx_run

from simx_client.launch.server import _redirects
from simx_client.transport.redirect import VARIABLE, redirected

pytestmark = pytest.mark.slow

PORTS = """
    import threading, multiprocessing
    import vrep
    from ports_of_mine import ARENA

    class Robot:
        def __init__(self, number, base=20000):
            self.id = vrep.simxStart(connectionAddress='localhost', connectionPort=base + number,
                                     waitUntilConnected=True, doNotReconnectOnceDisconnected=True,
                                     timeOutInMs=5000, commThreadCycleInMs=5)

    ids = [vrep.simxStart('127.0.0.1', port, True, True, 5000, 5) for port in (-19997, 19999, 25000, ARENA)]
    ids += [Robot(i).id for i in range(2)]
    ids.append(vrep.simxStart('192.168.0.7', int('1' + '9998'), True, True, 5000, 5))
    print(ids, vrep.simxSetIntegerSignal(ids[0], 'mark', 7, vrep.simx_opmode_blocking),
          {vrep.simxGetIntegerSignal(i, 'mark', vrep.simx_opmode_blocking) for i in ids})
    vrep.simxFinish(-1)
"""


def test_every_port_of_a_script_leads_to_its_server_also_those_it_computes(tmp_path: Path) -> None:
    (tmp_path / "ports_of_mine.py").write_text("ARENA = 30000 + 3\n")
    assert (
        output_of(tmp_path, PORTS, flags=("--server", "two_link_arm")) == "[0, 1, 2, 3, 4, 5, 6] 0 {(0, 7)}"
    )


def test_a_redirection_of_the_users_for_one_port_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "20000=127.0.0.1:1 *=127.0.0.1:2")
    text = "import os, vrep\nprint([vrep.simxStart('127.0.0.1', p, True, True, 500, 5) for p in (19997, 20000, 5)])"
    assert output_of(tmp_path, text, flags=("--server", "two_link_arm")) == "[0, -1, 1]"


def test_a_variable_that_cannot_be_read_is_refused_before_the_server_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "19997:4001")
    finished = simx_run(tmp_path, "print('script')", flags=("--server", "two_link_arm"))
    assert (finished.returncode, finished.stdout) == (1, "")
    assert "'19997:4001' is not PORT=HOST:PORT" in finished.stderr


def test_members_of_a_fleet_are_at_the_ports_from_19997_on(tmp_path: Path) -> None:
    text = """
        import vrep
        ids = [vrep.simxStart('127.0.0.1', 19997 + i, True, True, 5000, 5) for i in range(2)]
        vrep.simxSetIntegerSignal(ids[0], 'mark', 7, vrep.simx_opmode_blocking)
        print(ids, [vrep.simxGetIntegerSignal(i, 'mark', vrep.simx_opmode_blocking) for i in ids])
        vrep.simxFinish(-1)
    """
    flags = ("--server", "two_link_arm", "--server-args", "--count 2")
    assert output_of(tmp_path, text, flags=flags) == "[0, 1] [(0, 7), (8, 0)]"


def test_a_server_without_a_port_on_this_host_redirects_nothing() -> None:
    assert _redirects("ready tls/0.0.0.0:7447 realm=lab scene=arm\n") == {}
    assert _redirects("page http://127.0.0.1:8080\n") is None


@pytest.mark.parametrize(
    ("rules", "asked", "place"),
    [
        ("*=127.0.0.1:4001", ("10.0.0.5", 20000), ("127.0.0.1", 4001)),
        ("*=127.0.0.1:4001 20000=lab-pc:20000", ("127.0.0.1", 20000), ("lab-pc", 20000)),
        ("20000=lab-pc:20000,*=[::1]:4001", ("127.0.0.1", 5), ("[::1]", 4001)),
        ("*=127.0.0.1:4001", ("lab@router", 7447), ("lab@router", 7447)),
        ("7447=127.0.0.1:4001", ("lab@router", 7447), ("127.0.0.1", 4001)),
        ("19997=127.0.0.1:4001", ("127.0.0.1", 19999), ("127.0.0.1", 19999)),
        ("", ("127.0.0.1", 19999), ("127.0.0.1", 19999)),
    ],
)
def test_a_rule_for_the_port_wins_and_a_star_stands_for_all_others(
    monkeypatch: pytest.MonkeyPatch, rules: str, asked: tuple[str, int], place: tuple[str, int]
) -> None:
    monkeypatch.setenv(VARIABLE, rules)
    assert redirected(*asked) == place


@pytest.mark.parametrize("rules", ["*", "*=host", "x=127.0.0.1:1", "**=127.0.0.1:1", "-19997=127.0.0.1:1"])
def test_an_unreadable_rule_says_what_is_valid(monkeypatch: pytest.MonkeyPatch, rules: str) -> None:
    monkeypatch.setenv(VARIABLE, rules)
    with pytest.raises(ValueError, match=r"PORT=HOST:PORT, as in .*; \* for PORT means all others"):
        redirected("127.0.0.1", 19997)


def test_a_binding_that_is_kept_connects_to_the_port_of_the_flag(tmp_path: Path) -> None:
    (tmp_path / "vrep.py").write_text(
        "import ctypes\n# ctypes.CDLL('remoteApi.so')\ndef simxStart(connectionAddress, connectionPort, *others):\n"
        "    return connectionAddress, connectionPort, others\n"
    )
    script = "import vrep\nprint(vrep.simxStart('192.168.0.7', 19997, True), vrep.simxStart(b'pc', -3))"
    shown = output_of(tmp_path, script, flags=("--legacy", "4711"))
    assert shown == "('127.0.0.1', 4711, (True,)) (b'127.0.0.1', 4711, ())"


def test_a_port_that_is_served_already_excludes_a_private_server(tmp_path: Path) -> None:
    finished = simx_run(tmp_path, "", flags=("--legacy", "4711", "--server", "two_link_arm"))
    assert finished.returncode == 2
    assert "leave out --server, --embed and --pyrep" in finished.stderr
