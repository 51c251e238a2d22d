"""The files of a simulation: where scenes are searched, and which files clients have sent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from simx_server.scene.formats.sources import Sources

from .client_files import ClientFiles
from .scene_search import find_for_client

Find = Callable[[str, bool], Path]
"""Maps a client's text, and whether a model is meant, to a file. Raises CommandError."""


class SceneFiles:
    """Where a simulation finds files, and where its clients may store files."""

    def __init__(
        self, workspace: Path | None = None, sources: Sources | None = None, own_scene: Path | None = None
    ) -> None:
        """Make the list for one workspace.

        Args:
            workspace: the only folder, beside the shipped scenes and the folder of the present scene, from which
                clients may load files; the working directory if None. Without a workspace no file counts as a
                client's.
            sources: further places to search the files that scenes and models reference.
            own_scene: the scene that the server was started with; the operator trusts the files that it references.
        """
        self.workspace = (workspace or Path.cwd()).resolve()
        self.client_files = ClientFiles(None if workspace is None else self.workspace)
        self.sources = self._watched(sources or Sources.of())
        self.own_scene = own_scene
        self.more_folders: Sequence[Path] = ()
        """Further folders from which clients may load."""
        self.open_scene: Path | None = None
        """The file of the present scene; the simulation keeps it."""
        self.stored: dict[Path, int] = {}
        """Sizes in bytes of the files that clients have stored in the workspace."""
        self.made_folders: set[Path] = set()
        """Folders that were made for files that clients have stored."""
        self._find: Find = self._find_for_client

    def move_to(self, workspace: Path) -> None:
        """Use another workspace from now on, before any client has connected."""
        self.workspace = workspace.resolve()
        self.client_files = ClientFiles(self.workspace)

    def find(self, text: str, is_model: bool) -> Path:
        """Return the file that a client means. Raises CommandError."""
        return self._find(text, is_model)

    def find_by(self, find: Find) -> Find:
        """Find files by another function from now on, as a replay does; return the function before."""
        before, self._find = self._find, find
        return before

    def read_from(self, sources: Sources, folder: Path | None = None) -> None:
        """Search referenced files elsewhere from now on; let clients load from one folder more."""
        self.sources = self._watched(sources)
        if folder is not None:
            self.more_folders = [*self.more_folders, folder]

    def _watched(self, sources: Sources) -> Sources:
        def is_of_client(path: Path, data: bytes) -> bool:
            return self.client_files.holds(path, data)

        return replace(sources, is_of_client=is_of_client)

    def scene_opened(self, path: Path | None) -> None:
        """Note the file of the present scene."""
        self.open_scene = path

    def _find_for_client(self, text: str, is_model: bool) -> Path:
        return find_for_client(text, self.workspace, self.open_scene, self.more_folders, model=is_model)
