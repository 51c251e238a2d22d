"""simx-check evaluates the ports that a program connects to, without running it."""

from __future__ import annotations

from pathlib import Path

import pytest

from simx_client.checking.program import read_program
from simx_client.checking.reading.names import names_of
from simx_client.checking.wants import wants_of

MODULE = "ARENA = 30000 + 3\nclass Config:\n    port = 25000\n"


@pytest.mark.parametrize(
    ("text", "ports"),
    [
        ("start(19998)", [19998]),
        ("start(-19997)", [19997]),
        ("start('20000')", [20000]),
        ("start(int('20000'))", [20000]),
        ("BASE = 20000\nstart(BASE + 1)", [20001]),
        ("BASE = 20000\nfor i in range(3):\n    start(BASE + i * 2)", [20000, 20002, 20004]),
        ("for port in [19997, 19998]:\n    start(port)", [19997, 19998]),
        ("def connect(port=19999):\n    start(port)\nconnect()\nconnect(20005)", [19999, 20005]),
        ("class Robot:\n    def __init__(self, number):\n        self.port = 20000 + number\n"
         "    def go(self):\n        start(self.port)\nRobot(7)", [20007]),
        ("from settings_of_mine import ARENA\nstart(ARENA)", [30003]),
        ("import settings_of_mine as s\nstart(s.ARENA - 1)", [30002]),
        ("from settings_of_mine import Config\nstart(Config.port)", [25000]),
        ("p.add_argument('--sim-port', type=int, default=19996)\nargs = p.parse_args()\nstart(args.sim_port)", [19996]),
        ("import os\nstart(int(os.environ['PORT']))", []),
        ("start(19997 if fast else 19999)", [19997, 19999]),
        ("n = 1\nn = n + 1\nstart(n // 0)", []),
        ("start(70000)", []),
        ("for i in range(100000):\n    start(20000 + i)", []),
    ],
)  # fmt: skip
def test_a_port_is_known_as_far_as_the_text_shows_it(tmp_path: Path, text: str, ports: list[int]) -> None:
    (tmp_path / "settings_of_mine.py").write_text(MODULE)
    call = text.replace("start(", "vrep.simxStart('127.0.0.1', connectionPort=")
    script = tmp_path / "script.py"
    script.write_text("import vrep\n" + call + "\n")
    program = read_program(script)
    found = wants_of(program, names_of(program)).ports
    assert sorted(found) == ports
