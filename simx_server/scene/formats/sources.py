"""Search folders for the files that a scene names, beyond the scene's own folder: shipped parts and ROS packages.

A package is found by ``--package NAME=DIR``, then in the folders above the file, then by the variables of ROS and
Gazebo. A folder belongs to a package when it has the package's name or when its ``package.xml`` contains the name.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree

import mujoco

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.files.library import shipped_scenes
from simx_server.files.regular_files import is_file

from .contents import Contents

PACKAGE_FILE = "package.xml"

_MOST_DESCRIBED = 64 << 10
"""Largest package file in bytes; a longer one is not searched for a name."""

_SHARES = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH")
"""Variables of ROS 2: install prefixes, whose packages lie in ``share``."""

_ROOTS = (
    "ROS_PACKAGE_PATH",
    "GAZEBO_MODEL_PATH",
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
)
"""Variables with folders that hold packages or models."""

_SCHEMES = ("package", "model")


@dataclass(frozen=True)
class _Seen:
    """Results of the search for packages while one file is read."""

    names: dict[Path, str | None] = field(default_factory=dict[Path, str | None])
    """Names of folders, as given by their package's files."""

    within: dict[Path, list[Path]] = field(default_factory=dict[Path, list[Path]])
    """Folders in a root."""

    folders: dict[tuple[str, Path | None], tuple[Path, ...]] = field(
        default_factory=dict[tuple[str, Path | None], tuple[Path, ...]]
    )
    """Folders of packages, by name and the folder of the file that names them."""


@dataclass(frozen=True)
class Sources:
    """Search folders of one simulation."""

    shipped: Path
    """The folder of shipped scenes."""

    packages: Mapping[str, Path] = field(default_factory=dict[str, Path])
    """Folders of packages by name, from ``--package``."""

    roots: tuple[Path, ...] = ()
    """Folders that contain packages, from the environment."""

    within: tuple[Path, ...] | None = None
    """The only folders that may be searched (resolved), for files that clients name; None: any."""

    contents: Contents | None = field(default=None, compare=False, repr=False)
    """The only files there are, with their bytes, after a trial (`trial`); None: the files of the disk."""

    xacro_arguments: Mapping[str, str] = field(default_factory=dict[str, str])
    """Values of the arguments of xacro files, from ``--xacro``."""

    is_of_client: Callable[[Path, bytes], bool] | None = field(default=None, compare=False, repr=False)
    """Whether a client sent these bytes of a file. Any thread. None: none are a client's."""

    change: Callable[[mujoco.MjSpec], None] | None = field(default=None, compare=False, repr=False)
    """Changes what a scene's file says before it is compiled (`simx fit`). Raises SceneError. None: nothing does."""

    _seen: _Seen | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(
        cls,
        packages: Iterable[str] = (),
        environment: Mapping[str, str] | None = None,
        xacro_arguments: Mapping[str, str] | None = None,
    ) -> Sources:
        """Return sources from ``NAME=DIR`` texts, environment variables (default: the process's) and arguments."""
        variables = os.environ if environment is None else environment
        roots = [Path(part) for name in _ROOTS for part in _parts(variables, name)]
        roots += [Path(part) / "share" for name in _SHARES for part in _parts(variables, name)]
        pairs = (text.partition("=") for text in packages)
        return cls(
            shipped_scenes().resolve(),
            {name: Path(folder) for name, _, folder in pairs},
            tuple(dict.fromkeys(root for root in roots if root.is_absolute())),
            xacro_arguments=dict(xacro_arguments or {}),
        )

    def described(self) -> dict[str, Any]:
        """Return a description from which `described_as` makes the same sources."""
        return {
            "shipped": str(self.shipped),
            "packages": {name: str(folder) for name, folder in self.packages.items()},
            "roots": [str(root) for root in self.roots],
            "xacro": dict(self.xacro_arguments),
        }

    @classmethod
    def described_as(cls, described: Mapping[str, Any], place: Callable[[str], Path]) -> Sources:
        """Return sources from their description; `place` returns a folder's path. Raises KeyError and the like."""
        return cls(
            place(described["shipped"]),
            {str(name): place(folder) for name, folder in described["packages"].items()},
            tuple(place(root) for root in described["roots"]),
            xacro_arguments={str(name): str(value) for name, value in described.get("xacro", {}).items()},
        )

    def confined(self, folders: Iterable[Path]) -> Sources:
        """Return the same sources restricted to these folders, the shipped scenes and the operator's packages."""
        packages = [folder.resolve() for folder in self.packages.values()]
        return replace(self, within=(*folders, self.shipped, *packages))

    def for_one_read(self) -> Sources:
        """Return the same sources, which search each package once: files may change until the next read."""
        return self if self._seen is not None and self.contents is not None else replace(self, _seen=_Seen())

    def holding(self, contents: Contents) -> Sources:
        """Return the same sources, which read these bytes in place of files and know no other files."""
        return replace(self, contents=contents)

    def read(self, file: Path) -> bytes:
        """Return the bytes of a file. Raises OSError."""
        return file.read_bytes() if self.contents is None else self.contents.read(file)

    def trusts(self, path: Path, data: bytes) -> bool:
        """Return whether the operator has stored a file, not a client; `data`: its bytes as they were read."""
        return self.is_of_client is None or not self.is_of_client(path, data)

    def allows(self, path: Path) -> bool:
        """Return whether a file may be read; links are resolved."""
        if self.within is None:
            return True
        try:
            resolved = path.resolve()
        except (OSError, RuntimeError, ValueError):
            return False
        return any(resolved.is_relative_to(folder) for folder in self.within)

    def first(self, candidates: Iterable[Path]) -> Path | None:
        """Return the first allowed file, resolved, or None."""
        return next((path.resolve() for path in candidates if self.allows(path) and self._has(path)), None)

    def _has(self, path: Path) -> bool:
        if self.contents is None:
            return is_file(path)
        try:
            return self.contents.find(path.resolve()) is not None
        except (OSError, RuntimeError, ValueError):
            return False

    def candidates(self, uri: str, file: Path | None) -> Iterator[Path]:
        """Yield the files that a URI or path in a scene file may mean, the best first; they need not exist.

        Args:
            uri: ``package://NAME/PATH``, ``model://NAME/PATH``, ``file:///PATH`` or a path.
            file: the file that names it; None for a text without a file.
        """
        scheme, rest = _split(uri)
        if scheme in _SCHEMES:
            name, _, inside = rest.partition("/")
            for folder in self.package_folders(name, file):
                yield folder / inside
        elif Path(rest).is_absolute():
            yield Path(rest)
        elif file is not None:
            yield file.parent / rest

    def package_folders(self, name: str, file: Path | None) -> Iterable[Path]:
        """Return the folders that may be the package of this name, the best first."""
        if self._seen is None:
            return self._package_folders(name, file)
        key = name, None if file is None else file.parent
        if key not in self._seen.folders:
            self._seen.folders[key] = tuple(
                dict.fromkeys(filter(_is_folder, self._package_folders(name, file)))
            )
        return self._seen.folders[key]

    def _package_folders(self, name: str, file: Path | None) -> Iterator[Path]:
        if not name or name in (".", ".."):
            return
        if name in self.packages:
            yield self.packages[name]
        for folder in () if file is None else file.resolve().parents:
            if folder.name == name or self._package_name(folder) == name:
                yield folder
            yield folder / name
        for root in self.roots:
            if root.name == name or self._package_name(root) == name:
                yield root
            yield root / name
            yield from self._named_otherwise(root, name)

    def package_files(self, uri: str, file: Path) -> Iterator[Path]:
        """Yield each ``package.xml`` that locates a URI's package: a recording keeps them."""
        scheme, rest = _split(uri)
        if scheme in _SCHEMES:
            for folder in self.package_folders(rest.partition("/")[0], file):
                if self.allows(path := folder / PACKAGE_FILE) and path.is_file():
                    yield path.resolve()

    def _named_otherwise(self, root: Path, name: str) -> Iterator[Path]:
        """Yield packages below a root whose folder has another name, or lies in a repository's folder."""
        for folder in self._folders_within(root):
            if self._package_name(folder) == name:
                yield folder
            yield folder / name

    def _folders_within(self, root: Path) -> list[Path]:
        if self._seen is None:
            return self._list_folders(root)
        if root not in self._seen.within:
            self._seen.within[root] = self._list_folders(root)
        return self._seen.within[root]

    def _list_folders(self, root: Path) -> list[Path]:
        if not self.allows(root):
            return []
        try:
            return sorted(each for each in root.iterdir() if each.is_dir())
        except OSError:
            return []

    def _package_name(self, folder: Path) -> str | None:
        """Return the name in a folder's ``package.xml``, or None."""
        if self._seen is None:
            return self._read_package_name(folder)
        if folder not in self._seen.names:
            self._seen.names[folder] = self._read_package_name(folder)
        return self._seen.names[folder]

    def _read_package_name(self, folder: Path) -> str | None:
        path = folder / PACKAGE_FILE
        if not self.allows(path) or not is_file(path):
            return None
        try:
            with path.open("rb") as file:
                text = file.read(_MOST_DESCRIBED + 1)
            if len(text) > _MOST_DESCRIBED:
                return None
            name = ElementTree.fromstring(text).findtext("name")
        except (ElementTree.ParseError, OSError, ValueError, LookupError):
            return None
        return None if name is None else name.strip()


def _split(uri: str) -> tuple[str, str]:
    """Return the scheme ('' for a path) and the path; a drive of Windows is not a scheme."""
    scheme, sign, rest = uri.strip().partition("://")
    if not sign:
        return "", uri.strip().replace("\\", "/")
    scheme = scheme.lower()
    if scheme == "file":
        path = unquote(urlsplit(uri.strip()).path)
        # file:///C:/x is C:/x; file://relative/x, as some exporters write it, is a path from the file.
        host = rest.partition("/")[0]
        if host and host != "localhost":
            return "", unquote(rest)
        return "", path[1:] if os.name == "nt" and path[2:3] == ":" else path
    return scheme, rest.lstrip("/")


def _parts(variables: Mapping[str, str], name: str) -> list[str]:
    return [part for part in variables.get(name, "").split(os.pathsep) if part]


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False
