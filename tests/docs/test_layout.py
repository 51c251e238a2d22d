"""The layout of the code: who imports whom, and how many files a folder has."""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from processes import ROOT
from statements import parsed, statements

PACKAGES = ("simx_client", "simx_server")
MOST_FILES = 15
"""Python files in one folder, beside its `__init__.py`."""

MAY_IMPORT_THE_CLIENT = (
    "simx_server.viewer.page",
    "simx_server.gateways.embedded",
    "simx_server.app.embedding",
)
"""The web viewer is a client; the gateway within a process implements the client's transport."""


def files(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def modules() -> dict[str, Path]:
    return {module_of(path): path for package in PACKAGES for path in files(package)}


@cache
def written_imports(path: Path) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The modules that a file imports anywhere, as written there, with the names that it takes from each."""
    found: list[tuple[str, tuple[str, ...]]] = []
    for node in statements(parsed(path)):
        if isinstance(node, ast.Import):
            found += ((alias.name, ()) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = "." * node.level + (node.module or "")
            found.append((module, tuple(alias.name for alias in node.names)))
    return tuple(found)


@cache
def imports(module: str) -> frozenset[str]:
    """The modules that a module imports anywhere: within functions and for types too."""
    path = modules()[module]
    package = (module if path.name == "__init__.py" else module.rpartition(".")[0]).split(".")
    found: set[str] = set()
    for written, names in written_imports(path):
        name = written.lstrip(".")
        level = len(written) - len(name)
        above = package[: len(package) + 1 - level] if level else []
        base = ".".join([*above, *([name] if name else [])])
        found |= {f"{base}.{each}" if f"{base}.{each}" in modules() else base for each in names} or {base}
    return frozenset(name for name in found & modules().keys() if name != module)


def reached(module: str) -> set[str]:
    """All that a module imports, directly or through others."""
    seen: set[str] = set()
    waiting = [module]
    while waiting:
        new = imports(waiting.pop()) - seen
        seen |= new
        waiting += new
    return seen


def test_no_circle_of_imports_is_larger_than_three_files() -> None:
    try:
        TopologicalSorter({module: imports(module) for module in modules()}).prepare()
        return
    except CycleError:
        pass
    behind = {module: reached(module) for module in modules()}
    for module, others in behind.items():
        circle = sorted({other for other in others if module in behind[other]} | {module})
        assert len(circle) <= 3, f"these import each other: {circle}"


def test_the_server_imports_the_protocol_and_nothing_else_of_the_client() -> None:
    for module in modules():
        if module.startswith("simx_server") and not module.startswith(MAY_IMPORT_THE_CLIENT):
            wrong = [
                name
                for name in imports(module)
                if name.startswith("simx_client") and not name.startswith("simx_client.protocol")
            ]
            assert not wrong, f"{module} imports {wrong}"


def test_the_client_imports_nothing_of_the_server() -> None:
    for module in modules():
        if module.startswith("simx_client"):
            assert not [name for name in imports(module) if name.startswith("simx_server")], module


def test_dependence_runs_one_way_from_server_to_protocol() -> None:
    for path in (ROOT / "simx_client").rglob("*.py"):
        # The process that owns cv2's windows draws with cv2; the script's own process imports nothing of it.
        forbidden = (
            ("simx_server", "mujoco") if path.parent.name == "desk" else ("simx_server", "mujoco", "cv2")
        )
        for name, _ in written_imports(path):
            assert name.partition(".")[0] not in forbidden, path
    protocol = ROOT / "simx_client" / "protocol"
    for path in protocol.rglob("*.py"):
        above = "." * (2 + len(path.relative_to(protocol).parts) - 1)
        for name, _ in written_imports(path):
            top = name.partition(".")[0]
            assert not name.startswith(above), path
            is_within = f"{name}.".startswith("simx_client.protocol.")
            allowed = {*sys.stdlib_module_names, "msgpack", "zenoh", ""}
            # Who draws random values has NumPy; nothing else of the client imports that module.
            allowed |= {"numpy"} if path.name == "random_values.py" else set()
            assert is_within or top in allowed, path
    page = ROOT / "simx_server" / "viewer" / "page"
    nursery = ROOT / "simx_server" / "classroom" / "editor" / "nursery.py"
    for path in (ROOT / "simx_server").rglob("*.py"):
        if page in path.parents or path == nursery:
            continue  # processes of their own, and clients as any other
        for name, _ in written_imports(path):
            if name.startswith("simx_client"):
                # Only the ways within a process may know more of the client than the protocol: they implement its seam.
                is_within = path.name == "embedding.py" or path.parent.name in (
                    "loopback",
                    "embedded",
                    "crew",
                )
                assert name.startswith("simx_client.protocol") or is_within, path
            assert "viewer.page" not in name, path
            if path.parent == page.parent and path.name != "__main__.py":
                assert not name.startswith(".page"), path


def test_the_client_loads_no_module_of_the_server_by_name() -> None:
    for path in files("simx_client"):
        assert not re.search(r"""["']simx_server\.\w""", path.read_text(encoding="utf-8")), path


@pytest.mark.parametrize("part", ["simx_client", "simx_server", "bench", "tests"])
def test_no_folder_has_very_many_files(part: str) -> None:
    counts = Counter(path.parent for path in files(part) if path.name != "__init__.py")
    assert not {str(folder): count for folder, count in counts.items() if count > MOST_FILES}


def _content(folder: Path) -> str:
    """The first sentence of a folder's docstring."""
    text = ast.get_docstring(parsed(folder / "__init__.py")) or ""
    return " ".join(re.split(r"\.(?:\s|$)", text)[0].replace("``", "`").split())


@pytest.mark.parametrize("package", PACKAGES)
def test_contributing_has_each_folder_with_the_first_sentence_of_its_docstring(package: str) -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = page.partition(f"\n| folder of `{package}/` |")[2].partition("\n\n")[0]
    shown = re.findall(r"^\| `(\w+)/` \| (.*) \|$", table, re.MULTILINE)
    folders = sorted(path.parent for path in (ROOT / package).glob("*/__init__.py"))
    assert shown == [(folder.name, _content(folder)) for folder in folders]


_MEMBER = re.compile(r"(?:mujoco\.mjt\w+|_[A-Z]+)\.mj[A-Z]\w+")
_ARRAY = re.compile(r"\bmodel\.\w+_\w+(?:\[.*\])?")


def test_arrays_of_a_model_are_compared_with_numbers() -> None:
    """NumPy compares a member of an enumeration value by value in Python; its `value` is 50 to 300 times as fast."""
    slow = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in files("simx_server")
        if "mujoco.mjt" in path.read_text(encoding="utf-8")
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Compare)
        for sides in [[ast.unparse(each) for each in (node.left, *node.comparators)]]
        if any(map(_ARRAY.search, sides)) and any(map(_MEMBER.fullmatch, sides))
    ]
    assert not slow
