"""The flags of ``simx classroom``: what is refused, with what is valid, before anything starts."""

from __future__ import annotations

import logging
import socket
from pathlib import Path

import pytest

from simx_client import __main__ as simx
from simx_client.cli import server_command
from simx_server.classroom import command
from simx_server.classroom.addresses import AddressError, claim, resolve, shown_address

pytestmark = pytest.mark.slow


def refused(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    with pytest.raises(SystemExit) as left:
        simx.main(["classroom", *map(str, words)])
    assert left.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--seats", "0"), "a whole number from 1 to 100"),
        (("--seats", "many"), "a whole number from 1 to 100"),
        (("--page-port", "70000"), "a whole number from 0 to 65535"),
        (("--seat-memory", "5"), "a whole number from 200"),
        (("--host", "a b"), "an address of this machine"),
        (("--names", "nowhere.txt"), "No such file"),
        (("--workspace", "nowhere"), "an existing folder"),
        (("--speed", "fast"), "a number greater than 0, or max"),
        (("--seat", "3"), "did you mean '--seats'"),
        (("--listen", "tcp/0.0.0.0:1"), "unrecognized arguments"),
    ],
)
def test_value_that_cannot_be_used_is_refused(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], reason: str
) -> None:
    assert reason in refused(capsys, *words)


def test_names_must_fit_the_seats(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = tmp_path / "names.txt"
    names.write_text("Ada\n\n  Ben   B. \n", encoding="utf-8-sig")
    assert "1 seats are too few for the 2 names" in refused(capsys, "--names", names, "--seats", 1)
    names.write_text("\n \n")
    assert "it has no names" in refused(capsys, "--names", names)
    names.write_bytes(b"\xff\xfe\x00")
    assert "names.txt" in refused(capsys, "--names", names)
    names.write_text("\n".join(["x"] * 101))
    assert "at most 100 seats" in refused(capsys, "--names", names)


def test_scene_that_is_not_there_ends_the_start(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    words = ["classroom", "no_such_scene", "--page-port", "0", "--seat-port", "0"]
    with caplog.at_level(logging.ERROR):
        assert simx.main(words) == 1
    assert "no_such_scene" in caplog.text


def test_camera_that_the_scene_lacks_ends_the_start(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    words = ["cart_pole", "--camera", "nose", "--page-port", "0", "--seat-port", "0"]
    assert command.main(words) == 1
    assert "nose" in caplog.text
    assert "camera" in caplog.text


def test_unknown_way_to_draw_is_refused(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.setenv("MUJOCO_GL", "crayons")
    assert command.main(["cart_pole", "--page-port", "0", "--seat-port", "0"]) == 2
    assert "crayons" in caplog.text


def test_port_that_is_taken_ends_the_start(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert command.main(["--page-port", str(port), "--seat-port", "0"]) == 1
        assert "--page-port" in caplog.text
        caplog.clear()
        assert command.main(["--page-port", "0", "--seat-port", str(port)]) == 1
        assert "--seat-port" in caplog.text


def test_ports_of_seats_are_free_and_differ() -> None:
    assert len(set(claim("127.0.0.1", 0, 20, "--seat-port"))) == 20
    with pytest.raises(AddressError, match="at most 65506"):
        claim("127.0.0.1", 65530, 30, "--seat-port")


def test_address_for_students_is_one_that_they_can_use() -> None:
    assert resolve("localhost", "--host") in ("127.0.0.1", "::1")
    assert shown_address("10.1.2.3") == "10.1.2.3"
    assert shown_address("0.0.0.0") != "0.0.0.0"
    with pytest.raises(AddressError, match="not an address of this machine"):
        resolve("no-such-host.invalid", "--host")


def test_client_alone_names_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(server_command, "entry_points", lambda **_: ())
    assert simx.main(["classroom", "scene.xml", "--seats", "3"]) == 1
    assert "install" in capsys.readouterr().err
