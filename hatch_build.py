"""Compiles physics steps, distances, rays, inverse kinematics and V-REP's compression where there is a C compiler.

Without one, or without MuJoCo's headers, the package is built all the same: all then run in Python, with equal
results. `simx-server --doctor` says in which form each runs, and why.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = (
    Path("simx_server/joints/native/_physics_step.c"),
    Path("simx_server/joints/native/_crew.c"),
    Path("simx_server/sensors/distance/native/_triangle_pairs.c"),
    Path("simx_server/sensors/proximity/native/_first_hit.c"),
    Path("simx_server/kinematics/least_squares/native/_least_squares.c"),
    Path("simx_server/scene/formats/vrep/native/_huffman.c"),
)

PYREP_START = Path("packages/simx_pyrep.pth")
"""Read by each start of Python from the folder of packages; pyproject.toml adds it to a wheel."""


def module_of(source: Path) -> Path:
    """Return the path of the module that a source is compiled to, for every CPython from 3.11 on."""
    return source.with_suffix(".pyd" if sys.platform == "win32" else ".abi3.so")


class Build(BuildHookInterface[Any]):
    """Compiles beside the sources, where an editable installation finds the modules, and adds them to a wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the modules; a wheel with them is for this kind of machine only."""
        if self.target_name != "wheel":
            return
        if version == "editable":
            build_data["force_include_editable"] = {str(Path(self.root, PYREP_START)): PYREP_START.name}
        problem = compile_modules(Path(self.root))
        if problem:
            self.app.display_warning(
                f"physics steps, distances, rays and inverse kinematics will run in Python, which is slower: {problem}"
            )
            return
        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-{_platform_tag()}"
        build_data["artifacts"] += [f"/{module_of(source).as_posix()}" for source in SOURCES]


def compile_modules(root: Path) -> str:
    """Compile the modules; return why they cannot be, or an empty text. No old module is left then."""
    problem = next(filter(None, (_compile(root, source) for source in SOURCES)), "")
    if problem:
        for source in SOURCES:
            (root / module_of(source)).unlink(missing_ok=True)
    return problem


def _compile(root: Path, source: Path) -> str:
    if (headers := find_headers()) is None:
        return "the package mujoco, whose headers are needed, is not installed"
    if (compiler := find_compiler()) is None:
        return "there is no C compiler (on Debian or Ubuntu: apt-get install gcc)"
    if not Path(python := sysconfig.get_path("include"), "Python.h").exists():
        return f"{python} has no Python.h (on Debian or Ubuntu: apt-get install python3-dev)"
    module, source = root / module_of(source), root / source
    with tempfile.TemporaryDirectory(
        prefix=".build-", dir=module.parent
    ) as folder:  # linkers leave files of their own
        new = Path(folder, module.name)
        command = [
            *compiler,
            *shlex.split(os.environ.get("CFLAGS", "")),
            *("-O2", "-std=c11", "-fvisibility=hidden"),
            "-ffp-contract=off",  # a fused multiplication rounds once, NumPy twice
            f'-DSOURCE_HASH="{source_hash(source)}"',
            *(f"-I{folder}" for folder in (python, headers)),
            *(str(source), "-o", str(new)),
            *_link_flags(),
        ]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            return f"the C compiler failed: {done.stderr.strip() or done.stdout.strip()}"
        new.replace(module)  # at once, since programs may be starting
    return ""


def source_hash(source: Path) -> str:
    """Return what tells a module of this source, and of the headers beside it, from an older one."""
    texts = (source, *sorted(source.parent.glob("*.h")))
    return hashlib.sha256(b"".join(each.read_bytes() for each in texts)).hexdigest()[:16]


def _link_flags() -> list[str]:
    """Return what makes a module of a compiler's output; only Windows links the library of Python itself."""
    if sys.platform == "win32":
        return ["-shared", f"-L{Path(sys.base_prefix, 'libs')}", "-lpython3"]
    if sys.platform == "darwin":
        return ["-fPIC", "-bundle", "-undefined", "dynamic_lookup", "-lm"]
    return ["-fPIC", "-shared", "-lm"]


def find_headers() -> Path | None:
    """Return the headers of the MuJoCo that the environment has, or that of an isolated build."""
    folders = [Path(sysconfig.get_path(name)) / "mujoco" for name in ("platlib", "purelib")]
    found = importlib.util.find_spec("mujoco")
    if found is not None and found.origin is not None:
        folders.append(Path(found.origin).parent)
    return next((each / "include" for each in folders if (each / "include/mujoco/mujoco.h").exists()), None)


def find_compiler() -> list[str] | None:
    """Return the words of the compiler's command: of the variable CC, Python's own, or one with the flags of gcc."""
    known = (os.environ.get("CC"), sysconfig.get_config_var("CC"), "cc", "clang", "gcc")
    return next((words for each in known if each and shutil.which((words := shlex.split(each))[0])), None)


def _platform_tag() -> str:
    from packaging.tags import platform_tags

    # The first tag is the most specific; the plain one of Linux is what auditwheel starts from.
    tags = list(platform_tags())
    return next((tag for tag in tags if tag.startswith("linux_")), tags[0])
