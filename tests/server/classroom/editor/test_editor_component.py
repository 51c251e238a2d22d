"""Monaco's files: served from here under an address with their version, and nothing else of the machine."""

from __future__ import annotations

import gzip
from importlib.util import find_spec
from pathlib import Path

import pytest

from simx_server.classroom.editor import component
from simx_server.classroom.editor.component import Component, policy
from simx_server.classroom.page.http import Request


def asked(path: str, **headers: str) -> Request:
    return Request("GET", path, {}, headers)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Component:
    """A stand-in for the package, beside a file that is not to be read."""
    folder = tmp_path / "monaco_files"
    for name in ("vs/loader.js", "vs/assets/editor.worker-1.js", "vs/assets/ts.worker-1.js", "vs/notes.txt"):
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"text of {name}")
    (folder / "__init__.py").touch()
    (folder / "secret.js").write_text("secret")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(component, "PACKAGE", "monaco_files")
    monkeypatch.setattr(component.importlib.metadata, "version", lambda _name: "1.2")
    return Component()


def test_files_have_addresses_with_the_version_and_stay_in_browsers(installed: Component) -> None:
    assert installed.place == {"base": "/editor/1.2/vs", "worker": "/editor/1.2/vs/assets/editor.worker-1.js"}
    found = installed.file(asked("/editor/1.2/vs/loader.js"))
    assert found is not None
    assert (found.body, dict(found.headers)["Cache-Control"].split(",")[-1]) == (
        b"text of vs/loader.js",
        " immutable",
    )
    packed = installed.file(asked("/editor/1.2/vs/loader.js", **{"accept-encoding": "gzip, br"}))
    assert packed is not None
    assert gzip.decompress(packed.body) == found.body
    assert dict(packed.headers)["Content-Encoding"] == "gzip"


@pytest.mark.parametrize(
    "path",
    [
        "/editor/1.2/secret.js", "/editor/1.2/vs/../secret.js", "/editor/1.2/vs/notes.txt", "/editor/1.1/vs/loader.js",
        "/editor/1.2//etc/passwd", "/vs/loader.js", "vs/loader.js", "/editor/1.2/vs/assets/ts.worker-1.js", "/",
    ],
)  # fmt: skip
def test_other_files_are_not_there(installed: Component, path: str) -> None:
    assert installed.file(asked(path)) is None


def test_without_the_package_the_page_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(component, "PACKAGE", "no_such_package")
    plain = Component()
    assert plain.place == {}
    assert plain.missing.split()[:2] == ["pip", "install"]  # without a path of the teacher's machine
    assert plain.file(asked("/editor//vs/loader.js")) is None


def test_page_allows_scripts_of_this_server_alone() -> None:
    name, rules = policy(20_203)
    assert name == "Content-Security-Policy"
    parts = dict(part.strip().split(" ", 1) for part in rules.split(";"))
    assert parts["default-src"] == "'self'"
    assert "script-src" not in parts  # so that of default-src holds
    assert parts["frame-src"] == "http://*:20203"
    assert parts["frame-ancestors"] == "'none'"
    assert "frame-src" not in policy(None)[1]


@pytest.mark.skipif(find_spec(component.PACKAGE) is None, reason="the extra editor is not installed")
def test_the_package_has_the_files_that_the_page_loads() -> None:
    found = Component()
    for path in (
        f"{found.place['base']}/loader.js",
        f"{found.place['base']}/editor/editor.main.css",
        found.place["worker"],
    ):
        assert found.file(asked(path)) is not None, path
