"""An open gateway is warned of, and a configuration of the user's own opens none by what it leaves out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from processes import PENDULUM, finished

from simx_client.protocol.zenoh import link
from simx_server.gateways.exposure import exposure, plain_exposure

pytestmark = pytest.mark.slow

LOGIN = {"transport/auth/usrpwd": {"dictionary_file": "users.txt"}}
MUTUAL = {"transport/link/tls/enable_mtls": True}


@pytest.mark.parametrize(
    ("endpoint", "options", "is_open"),
    [
        ("tcp/127.0.0.1:7447", {}, False),
        ("tcp/127.1.2.3:7447", {}, False),
        ("tcp/[::1]:7447", {}, False),
        ("tls/localhost:7447", {}, False),
        ("unixsock-stream//tmp/simx", {}, False),
        ("tcp/0.0.0.0:7447", {}, True),
        ("tcp/[::]:7447#iface=eth0", {}, True),
        ("udp/192.168.1.5:7447", {}, True),
        ("ws/lab-pc:7447", {}, True),
        ("tls/0.0.0.0:7447", {}, True),
        ("tls/0.0.0.0:7447", MUTUAL, False),
        ("quic/0.0.0.0:7447", MUTUAL, False),
        ("tcp/0.0.0.0:7447", MUTUAL, True),
        ("tcp/0.0.0.0:7447", LOGIN, False),
    ],
)
def test_open_gateway_is_known_as_one(endpoint: str, options: dict[str, Any], is_open: bool) -> None:
    config = link.configure(link.import_zenoh().Config(), options)
    warning = exposure(["tcp/127.0.0.1:19997", endpoint], config)
    assert (warning is not None) == is_open
    if warning is not None:
        assert endpoint in warning
        assert "19997" not in warning
        assert "--config" in warning


def test_a_port_without_passwords_is_open_unless_it_is_of_this_machine_alone() -> None:
    assert plain_exposure(["127.0.0.1:19997", "127.0.0.2:1"]) is None
    warning = plain_exposure(["127.0.0.1:19997", "192.168.1.5:4000"])
    assert warning is not None
    assert "192.168.1.5:4000" in warning
    assert "19997" not in warning


@pytest.mark.parametrize("flags", [[], ["--config", "nobody.json5"]])
def test_server_that_is_open_to_all_warns_and_serves(tmp_path: Path, flags: list[str]) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    (tmp_path / "nobody.json5").write_text("{}")
    flags = ["--port", "0", "--duration", "0.1", "--listen", "tcp/0.0.0.0:0", *flags]
    done = finished("-m", "simx_server", "pendulum.xml", *flags, folder=tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith("ready ")
    (line,) = [line for line in done.stderr.splitlines() if "WARNING" in line]
    assert "tcp/0.0.0.0:0" in line
    assert "docs/operators/security.md" in line


def test_file_of_the_user_keeps_what_simx_has_chosen_and_it_does_not_say(tmp_path: Path) -> None:
    zenoh = link.import_zenoh()
    (tmp_path / "a.json5").write_text("{ transport: { unicast: { open_timeout: 700 } } }")
    config = link.configured_by(zenoh, tmp_path / "a.json5", link.COMMON)
    assert config.get_json("transport/unicast/open_timeout") == "700"
    assert config.get_json("transport/link/tx/lease") == str(link.LEASE_MS)
    assert config.get_json("scouting/multicast/enabled") == "false"
    (tmp_path / "b.json5").write_text("{ scouting: { multicast: { enabled: true } } }")
    config = link.configured_by(zenoh, tmp_path / "b.json5", link.COMMON)
    assert config.get_json("scouting/multicast/enabled") == "true"


@pytest.mark.parametrize(("text", "is_enabled"), [("{}", False), ("{ mode: 'init' }", True)])
def test_shared_memory_is_the_operators_choice(tmp_path: Path, text: str, is_enabled: bool) -> None:
    (tmp_path / "a.json5").write_text(f"{{ transport: {{ shared_memory: {text} }} }}")
    config = link.configured_by(link.import_zenoh(), tmp_path / "a.json5", link.SERVER)
    assert json.loads(config.get_json("transport/shared_memory/enabled")) is is_enabled
