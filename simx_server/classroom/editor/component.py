"""Monaco, the editor of the extra ``editor``: its files, which browsers load from here and from no other place."""

from __future__ import annotations

import gzip
import importlib.metadata
import importlib.util
from functools import cache
from http import HTTPStatus
from pathlib import Path

from simx_client.protocol.cli.installing import extra_line
from simx_server.classroom.page.http import POLICY, Request, Response

PACKAGE = "rocher"
FOREVER = ("Cache-Control", "public, max-age=31536000, immutable")
"""Browsers keep a file: its address has the version."""

KINDS = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".ttf": "font/ttf",
}
_OF_OTHER_LANGUAGES = ("ts.worker", "css.worker", "html.worker", "json.worker")
_WORKER = "vs/assets/editor.worker"


class Component:
    """The files, by name. Without the package there are none."""

    def __init__(self) -> None:
        """Find the files."""
        found = importlib.util.find_spec(PACKAGE)
        folders = [] if found is None else found.submodule_search_locations or []
        self._files = {name: path for folder in folders for name, path in _files(Path(folder)).items()}
        version = importlib.metadata.version(PACKAGE) if self._files else ""
        self._prefix = f"/editor/{version}/"

    @property
    def place(self) -> dict[str, str]:
        """Return the addresses that the page needs; empty without the package."""
        worker = next((name for name in self._files if name.startswith(_WORKER)), "")
        return {"base": f"{self._prefix}vs", "worker": self._prefix + worker} if worker else {}

    @property
    def missing(self) -> str:
        """Return what to install for a better editor; empty if it is there."""
        return "" if self._files else line_for_students("editor")

    def file(self, request: Request) -> Response | None:
        """Return the file at an address; None if there is none."""
        path = self._files.get(request.path.removeprefix(self._prefix))
        if path is None or not request.path.startswith(self._prefix):
            return None
        headers: tuple[tuple[str, str], ...] = (FOREVER,)
        if "gzip" not in request.headers.get("accept-encoding", ""):
            return Response(HTTPStatus.OK, path.read_bytes(), KINDS[path.suffix], headers)
        headers += (("Content-Encoding", "gzip"),)
        return Response(HTTPStatus.OK, _compressed(path), KINDS[path.suffix], headers)


def line_for_students(extra: str) -> str:
    """Return what the teacher has to run to install an extra, without paths of the teacher's machine."""
    return extra_line(extra).rpartition(" -m ")[2]


def _files(folder: Path) -> dict[str, Path]:
    return {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.joinpath("vs").rglob("*"))
        if path.suffix in KINDS and not path.name.startswith(_OF_OTHER_LANGUAGES)
    }


@cache
def _compressed(path: Path) -> bytes:
    return gzip.compress(path.read_bytes(), 6)


def policy(view_port: int | None) -> tuple[str, str]:
    """Return the header with the rules of the editor's page.

    Monaco sets styles of elements, so styles in the page are allowed. Scripts are those of this server, and no others.

    Args:
        view_port: of the seat's 3-D view, which the page shows in a frame; None: there is none.
    """
    frames = "" if view_port is None else f"; frame-src http://*:{view_port}"
    rules = f"{POLICY}; style-src 'self' 'unsafe-inline'; font-src 'self' data:{frames}"
    return "Content-Security-Policy", rules
