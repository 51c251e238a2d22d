"""Takes what the wheel of the client shares with the whole package from the repository's own pyproject.toml.

A source archive of the client holds the results (PKG-INFO) and the package, so the repository is not needed there.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

PACKAGE = "simx_client"
SAME = ("authors", "classifiers", "keywords", "license", "requires-python", "urls")
DEPENDENCIES = ("eclipse-zenoh", "msgpack")
EXTRAS = {"python2": ("fissix",)}
"""What the client can use besides."""

SAME_EXTRAS = ("gym", "learning", "ray")
"""Those of the whole package that need no server here: environments on servers elsewhere, fleets."""

REPOSITORY = Path(__file__).resolve().parents[2]


def requirements(names: tuple[str, ...], of_all: list[str]) -> list[str]:
    """Return the requirements on these packages as the whole package has them."""
    known = {re.split(r"[^\w.-]", each, maxsplit=1)[0]: each for each in of_all}
    return [known[name] for name in names]


class Metadata(MetadataHookInterface):
    """Fills in the fields of ``[project]`` that are dynamic."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the fields, unless PKG-INFO has provided them, as in a source archive."""
        if not metadata.get("dynamic") or (Path(self.root) / PACKAGE).is_dir():
            return
        whole = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
        project = whole["project"]
        version = (REPOSITORY / whole["tool"]["hatch"]["version"]["path"]).read_text(encoding="utf-8")
        found = re.search(r'^__version__ = "(.+)"$', version, re.MULTILINE)
        assert found is not None
        metadata["version"] = found[1]
        metadata["dependencies"] = requirements(DEPENDENCIES, project["dependencies"])
        metadata["optional-dependencies"] = {
            extra: requirements(names, project["dependencies"]) for extra, names in EXTRAS.items()
        } | {extra: project["optional-dependencies"][extra] for extra in SAME_EXTRAS}
        metadata.update(
            {name: project[name] for name in SAME if name in project}
        )  # urls: once there is an address


class Build(BuildHookInterface[Any]):
    """Adds the package: from beside this file in a source archive, otherwise from the repository."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the package to what is built."""
        here = Path(self.root) / PACKAGE
        build_data["force_include"][str(here if here.is_dir() else REPOSITORY / PACKAGE)] = PACKAGE
