"""The build compiles the modules in C where it can, and says in a line why it cannot."""

from __future__ import annotations

import importlib.util
import shutil
import sys
from pathlib import Path
from types import ModuleType

import pytest
from processes import ROOT

pytest.importorskip("hatchling")


@pytest.fixture(scope="module")
def hook() -> ModuleType:
    spec = importlib.util.spec_from_file_location("hatch_build_of_project", ROOT / "hatch_build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def tree(tmp_path: Path, hook: ModuleType) -> Path:
    """A tree with nothing but the sources, and with modules of an earlier build."""
    for source in hook.SOURCES:
        folder = tmp_path / source.parent
        folder.mkdir(parents=True, exist_ok=True)
        for text in (ROOT / source, *(ROOT / source.parent).glob("*.h")):
            shutil.copy(text, folder)
        (tmp_path / hook.module_of(source)).write_bytes(b"old")
    return tmp_path


def modules(tree: Path, hook: ModuleType) -> list[Path]:
    """Return the compiled modules of a tree."""
    return [path for source in hook.SOURCES if (path := tree / hook.module_of(source)).exists()]


def test_every_source_in_c_is_compiled(hook: ModuleType) -> None:
    """`packages/check_dist.py` counts the sources of the tree."""
    assert sorted(hook.SOURCES) == sorted(
        path.relative_to(ROOT) for path in ROOT.glob("simx_server/**/native/*.c")
    )


def test_without_a_compiler_no_module_is_left(
    tree: Path, hook: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tree))
    monkeypatch.setenv("CC", "no-such-compiler -O2")
    monkeypatch.setattr(hook.sysconfig, "get_config_var", lambda _name: None)
    assert hook.compile_modules(tree).startswith("there is no C compiler")
    assert not modules(tree, hook)


def test_without_headers_of_python_their_package_is_named(
    tree: Path, hook: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hook.sysconfig, "get_path", lambda _name: str(tree))
    monkeypatch.setattr(hook, "find_headers", lambda: tree)
    assert "Python.h (on Debian or Ubuntu: apt-get install python3-dev)" in hook.compile_modules(tree)
    assert not modules(tree, hook)


def test_a_compiler_that_fails_leaves_no_module(
    tree: Path, hook: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", f"{sys.executable} -c 'raise SystemExit(\"out of order\")'")
    assert hook.compile_modules(tree) == "the C compiler failed: out of order"
    assert not modules(tree, hook)


def test_without_headers_no_module_is_left(
    tree: Path, hook: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hook, "find_headers", lambda: None)
    assert "headers" in hook.compile_modules(tree)
    assert not modules(tree, hook)


@pytest.mark.parametrize(
    ("system", "name", "flags"),
    [
        ("linux", "_physics_step.abi3.so", ["-fPIC", "-shared", "-lm"]),
        ("darwin", "_physics_step.abi3.so", ["-fPIC", "-bundle", "-undefined", "dynamic_lookup", "-lm"]),
        ("win32", "_physics_step.pyd", ["-shared", f"-L{Path(sys.base_prefix, 'libs')}", "-lpython3"]),
    ],
)
def test_each_system_has_its_own_flags_and_names_of_modules(
    system: str,
    name: str,
    flags: list[str],
    tree: Path,
    hook: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    """Stands in for the compiler of another system: it writes its arguments, and a file beside its output."""
    compiler = tmp_path / "compiler.py"
    compiler.write_text(
        "import pathlib, sys\n"
        "out = pathlib.Path(sys.argv[sys.argv.index('-o') + 1])\n"
        "out.write_text('\\n'.join(sys.argv)); out.with_suffix('.lib').write_text('')\n",
        encoding="utf-8",
    )
    monkeypatch.setattr(hook.sys, "platform", system)
    monkeypatch.setenv("CC", f"{sys.executable} {compiler}")
    assert hook.compile_modules(tree) == ""
    first, *_ = found = modules(tree, hook)
    assert (len(found), first.name) == (len(hook.SOURCES), name)
    assert first.read_text(encoding="utf-8").splitlines()[-len(flags) :] == flags
    folder = ROOT / hook.SOURCES[0].parent
    made = {hook.module_of(source).name for source in hook.SOURCES if (ROOT / source).parent == folder}
    texts = {each.name for each in folder.iterdir() if each.suffix in (".c", ".h")}
    beside = {each.name for each in first.parent.iterdir()}
    assert {each for each in beside if not each.endswith(".so")} == {
        each for each in made | texts if not each.endswith(".so")
    }
