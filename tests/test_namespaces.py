"""Hosts of their own, as network namespaces: two servers and a client joined by a router, and a cable pulled.

Needs the rights to make namespaces and tun devices (root, iproute2); skipped elsewhere. A pulled cable says nothing to
anyone: what is behind it is noticed by its silence.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from processes import PENDULUM, ROOT, read_line, running, wait_until

PATIENCE = 30.0
HOSTS = ("client", "north", "east")
READ = """
import simx_client as v
client = v.simxStart("{realm}@{router}", 7447, True, True, 5000, 5)
handle = v.simxGetObjectHandle(client, "hinge", v.simx_opmode_blocking)[1]
print(v.simxGetJointPosition(client, handle, v.simx_opmode_blocking)[0])
"""


def _ip(*words: object) -> None:
    subprocess.run(["ip", *map(str, words)], check=True, capture_output=True)


def _namespaces_are_allowed() -> bool:
    if sys.platform != "linux" or shutil.which("ip") is None:
        return False
    name = f"simx{os.getpid()}try"
    try:
        _ip("netns", "add", name)
        _ip("-n", name, "tuntap", "add", "dev", "a", "mode", "tun")
    except subprocess.CalledProcessError:
        return False
    finally:
        subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)
    return True


class Lab:
    """One namespace per host and one for the router, each host with a cable of its own to it."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self._cables: dict[str, subprocess.Popen[str]] = {}
        router = self._namespace("router")
        for number, host in enumerate(HOSTS, 1):
            namespace = self._namespace(host)
            self._cables[host] = self._started(
                [sys.executable, str(ROOT / "tests" / "tun_cable.py"), router, host, namespace, "wire"]
            )
            for owner, device, end in ((router, host, 1), (namespace, "wire", 2)):
                _ip("-n", owner, "address", "add", f"10.77.{number}.{end}/24", "dev", device)
                _ip("-n", owner, "link", "set", device, "up")
        self.start("router", ROOT / "tests" / "zenoh_router.py", "tcp/0.0.0.0:7447")

    def _namespace(self, host: str) -> str:
        name = self._name(host)
        _ip("netns", "add", name)
        self._stack.callback(_ip, "netns", "del", name)
        _ip("-n", name, "link", "set", "lo", "up")
        return name

    def _name(self, host: str) -> str:
        return f"simx{os.getpid()}{host}"

    def router_of(self, host: str) -> str:
        """The router's address as this host knows it."""
        return f"10.77.{1 + HOSTS.index(host)}.1"

    def command(self, host: str, *arguments: object) -> list[str]:
        return ["ip", "netns", "exec", self._name(host), sys.executable, *map(str, arguments)]

    def start(self, host: str, *arguments: object) -> None:
        """Start Python on a host; returns when it says that it is ready."""
        self._started(self.command(host, *arguments))

    def _started(self, command: list[str]) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT, bufsize=1
        )
        self._stack.enter_context(running(process))
        assert process.stdin is not None
        self._stack.callback(process.stdin.close)
        assert read_line(process).startswith("ready")
        return process

    def run(self, host: str, *arguments: object) -> str:
        done = subprocess.run(
            self.command(host, *arguments), capture_output=True, text=True, cwd=ROOT, timeout=PATIENCE
        )
        return done.stdout

    def tell_cable(self, host: str, word: str) -> None:
        """``cut`` or ``mend``."""
        cable = self._cables[host]
        assert cable.stdin is not None
        cable.stdin.write(word + "\n")
        assert read_line(cable) == "done\n"

    def listed(self) -> dict[str, str]:
        """Realm to state, as the client's host sees it."""
        endpoint = f"tcp/{self.router_of('client')}:7447"
        text = self.run(
            "client", "-m", "simx_client", "list", "--json", "--timeout", 0.5, "--connect", endpoint
        )
        return {record["realm"]: record["state"] for record in json.loads(text)}

    def read(self, realm: str) -> str:
        """The return code of a blocking read by a client."""
        return self.run("client", "-c", READ.format(realm=realm, router=self.router_of("client"))).strip()


@contextmanager
def lab() -> Iterator[Lab]:
    with ExitStack() as stack:
        yield Lab(stack)


def test_a_host_whose_cable_is_pulled_is_gone_after_a_while_and_comes_back(tmp_path: Path) -> None:
    if not _namespaces_are_allowed():
        pytest.skip("no rights to make network namespaces")
    scene = tmp_path / "pendulum.xml"
    scene.write_text(PENDULUM)
    with lab() as hosts:
        for realm in ("north", "east"):
            router = f"tcp/{hosts.router_of(realm)}:7447"
            hosts.start(realm, "-m", "simx_server", scene, "--port", 0, "--realm", realm, "--connect", router)
        both = {"north": "stopped", "east": "stopped"}
        assert wait_until(lambda: hosts.listed() == both, PATIENCE)
        assert hosts.read("north") == hosts.read("east") == "0"
        hosts.tell_cable("east", "cut")
        assert hosts.listed()["east"] == "no answer"
        assert hosts.read("north") == "0"
        assert wait_until(lambda: hosts.listed() == {"north": "stopped"}, PATIENCE)
        hosts.tell_cable("east", "mend")
        assert wait_until(lambda: hosts.listed() == both, PATIENCE)
        assert hosts.read("east") == "0"
