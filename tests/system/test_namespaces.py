"""Hosts of their own, as network namespaces: two servers and a client joined by a router, and a cable pulled.

Needs the rights to make namespaces and tun devices (root, iproute2); skipped elsewhere. A pulled cable says nothing to
anyone: what is behind it is noticed by its silence.
"""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from processes import ROOT, read_line, running, wait_until

pytestmark = pytest.mark.slow

TIMEOUT = 30.0
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

    def __init__(self, stack: ExitStack, hosts: Sequence[str]) -> None:
        """The first of the hosts is the client's."""
        self._stack = stack
        self._hosts = hosts
        self._cables: dict[str, subprocess.Popen[str]] = {}
        router = self._namespace("router")
        for number, host in enumerate(hosts, 1):
            namespace = self._namespace(host)
            self._cables[host] = self._started(
                [
                    sys.executable,
                    str(ROOT / "tests" / "support" / "programs" / "tun_cable.py"),
                    router,
                    host,
                    namespace,
                    "wire",
                ]
            )
            for owner, device, end in ((router, host, 1), (namespace, "wire", 2)):
                _ip("-n", owner, "address", "add", f"10.77.{number}.{end}/24", "dev", device)
                _ip("-n", owner, "link", "set", device, "up")

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
        return f"10.77.{1 + self._hosts.index(host)}.1"

    def command(self, host: str, *arguments: object) -> list[str]:
        return ["ip", "netns", "exec", self._name(host), sys.executable, *map(str, arguments)]

    def start(self, host: str, *arguments: object) -> subprocess.Popen[str]:
        """Start Python on a host; returns when it says that it is ready."""
        return self._started(self.command(host, *arguments))

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
            self.command(host, *arguments), capture_output=True, text=True, cwd=ROOT, timeout=TIMEOUT
        )
        return done.stdout

    def tell_cable(self, host: str, word: str) -> None:
        """See `tun_cable.py`; its second end is the host's."""
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
def lab(hosts: Sequence[str] = HOSTS) -> Iterator[Lab]:
    if not _namespaces_are_allowed():
        pytest.skip("no rights to make network namespaces")
    with ExitStack() as stack:
        yield Lab(stack, hosts)


def test_a_host_whose_cable_is_pulled_is_gone_after_a_while_and_comes_back(scene: Path) -> None:
    with lab() as hosts:
        hosts.start("router", ROOT / "tests" / "support" / "programs" / "zenoh_router.py", "tcp/0.0.0.0:7447")
        for realm in ("north", "east"):
            router = f"tcp/{hosts.router_of(realm)}:7447"
            hosts.start(realm, "-m", "simx_server", scene, "--port", 0, "--realm", realm, "--connect", router)
        both = {"north": "stopped", "east": "stopped"}
        assert wait_until(lambda: hosts.listed() == both, TIMEOUT)
        assert hosts.read("north") == hosts.read("east") == "0"
        hosts.tell_cable("east", "cut")
        assert hosts.listed()["east"] == "no answer"
        assert hosts.read("north") == "0"
        assert wait_until(lambda: hosts.listed() == {"north": "stopped"}, TIMEOUT)
        hosts.tell_cable("east", "mend")
        assert wait_until(lambda: hosts.listed() == both, TIMEOUT)
        assert hosts.read("east") == "0"


class Caller:
    """A client on a host of its own that calls when it is told to, see `link_client.py`."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def tell(self, *words: object) -> dict[str, Any]:
        """Its answer."""
        assert self._process.stdin is not None
        self._process.stdin.write(" ".join(map(str, words)) + "\n")
        self._process.stdin.flush()
        return json.loads(read_line(self._process))

    def calls(self, number: int) -> tuple[set[int], float, float]:
        """(codes, median milliseconds, longest) of so many blocking calls."""
        answer = self.tell("call", number)
        took = [1000 * seconds for seconds in answer["seconds"]]
        return set(answer["codes"]), statistics.median(took), max(took)


def test_a_slow_network_that_loses_packets_is_slow_and_loses_no_call(
    scene: Path, record_property: Callable[[str, object], None]
) -> None:
    """After a short cut it is the same connection; half open it is given up, and taken up again when it is mended."""
    with lab(["client"]) as hosts:
        address = f"tcp/{hosts.router_of('client')}:19997"
        flags = ("--start", "--port", 0, "--no-local", "--listen", address)
        hosts.start("router", "-m", "simx_server", scene, *flags)
        caller = Caller(
            hosts.start(
                "client",
                ROOT / "tests" / "support" / "programs" / "link_client.py",
                hosts.router_of("client"),
                19997,
            )
        )

        def seconds_until(is_so: Callable[[dict[str, Any]], bool]) -> float:
            began = time.monotonic()
            assert wait_until(lambda: is_so(caller.tell("look")), TIMEOUT)
            return time.monotonic() - began

        figures = [f"{'well':>22}: {caller.calls(50)[1]:.1f} ms a call"]
        for words in (["delay 0.02"], ["delay 0.02", "lose 20"]):
            for word in words:
                hosts.tell_cable("client", word)
            codes, middle, most = caller.calls(20)
            assert codes == {0}
            assert middle > 40
            figures.append(f"{', '.join(words):>22}: {middle:.0f} ms a call, most {most:.0f} ms, none lost")
        for word in ("delay 0", "lose 0"):
            hosts.tell_cable("client", word)

        hosts.tell_cable("client", "cut")  # for less than the lease
        codes, middle, _ = caller.calls(3)
        assert codes == {3}
        hosts.tell_cable("client", "mend")
        back = seconds_until(lambda seen: seen["code"] == 0)
        assert caller.tell("look")["connection"] == 1
        figures.append(f"{'cut and mended':>22}: three calls time out, answered again after {back:.2f} s")

        hosts.tell_cable("client", "deaf")  # what it sends is lost, what it is sent still comes
        lost = seconds_until(lambda seen: seen["connection"] == -1)
        assert caller.tell("look")["streamed"] == 1, "nothing old is given as new"
        hosts.tell_cable("client", "mend")
        back = seconds_until(lambda seen: seen["streamed"] == 0)
        assert caller.tell("look")["connection"] == 2
        figures.append(f"{'deaf in one direction':>22}: noticed after {lost:.1f} s")
        figures.append(f"{'mended':>22}: streams come again after {back:.2f} s")
    for figure in figures:
        record_property("figures", f"network {figure}")
