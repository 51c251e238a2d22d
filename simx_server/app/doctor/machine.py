"""Check Python, the packages and the resources of the machine: cores, memory, a writable folder."""

from __future__ import annotations

import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator
from importlib import import_module, metadata
from pathlib import Path

from simx_client.protocol.cli.installing import DISTRIBUTION, by_extra, declared, line, name_of, package_line
from simx_server.compiled import HOW_TO_COMPILE

from .findings import OK, PROBLEM, WARNING, Finding

LEAST_PYTHON = (3, 11)
LEAST_MEMORY = 512 << 20
"""Bytes; a server with the tutorial's scene and images takes about 300 MB."""

LEAST_DISK = 100 << 20
_FOR_DEVELOPERS = "dev"


def check_python() -> Finding:
    """Check version, implementation and system."""
    version = platform.python_version()
    text = f"{platform.python_implementation()} {version} on {platform.platform()}, {sys.executable}"
    if sys.version_info[:2] < LEAST_PYTHON:
        least = ".".join(map(str, LEAST_PYTHON))
        return Finding(PROBLEM, "python", text, f"install Python {least} or newer, and the package there")
    return Finding(OK, "python", text)


def check_packages(requirements: Iterable[str] | None = None) -> Iterator[Finding]:
    """Check the required packages and the extras; `requirements`: metadata lines, by default those of this package."""
    wanted = declared() if requirements is None else by_extra(requirements)
    if not wanted:
        text = f"{DISTRIBUTION} is not installed, so nobody knows what it requires"
        yield Finding(WARNING, "packages", text, "install it with the path of its clone, or of its wheel")
        return
    versions = {each: _version(name_of(each)) for each in wanted.get(None, ())}
    missing = [each for each, version in versions.items() if version is None]
    here_perhaps = [each for each in missing if ";" in each]
    needed = [each for each in missing if ";" not in each]
    if here_perhaps:
        names = [name_of(each) for each in here_perhaps]
        text = f"not installed, since there is no wheel for every system: {', '.join(names)}"
        yield Finding(WARNING, "packages", text, f"where there is a C++ compiler: {package_line(*names)}")
    if needed:
        text = f"not installed: {', '.join(map(name_of, needed))}"
        yield Finding(PROBLEM, "packages", text, line(needed))
    there = ", ".join(
        f"{name_of(each)} {version}" for each, version in versions.items() if version is not None
    )
    yield Finding(OK, "packages", there or "none")
    for extra, packages in wanted.items():
        if extra is None or extra == _FOR_DEVELOPERS:
            continue
        missing = [each for each in packages if _version(name_of(each)) is None]
        if missing:
            text = f"{extra} is not installed (without: {', '.join(map(name_of, missing))})"
            yield Finding(OK, "extras", text, f"if you want it: {line(missing)}")
        else:
            yield Finding(OK, "extras", f"{extra} is installed ({', '.join(map(name_of, packages))})")


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def check_cores() -> Finding:
    """Check how many cores this process may use."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if cores < 2:
        text = "1 core: physics, images, Zenoh and the script share it"
        return Finding(
            WARNING, "cores", text, "expect less than real time with images; give it a second core"
        )
    return Finding(OK, "cores", f"{cores} cores")


def check_memory(free: int | None = None) -> Finding:
    """Check the free memory in bytes; by default Linux's available memory."""
    free = _available_memory() if free is None else free
    if free is None:
        return Finding(OK, "memory", f"not known on {platform.system()}")
    text = f"{free >> 20} MB free"
    if free < LEAST_MEMORY:
        advice = f"end other programs; a server with images takes about {LEAST_MEMORY >> 20} MB"
        return Finding(WARNING, "memory", text, advice)
    return Finding(OK, "memory", text)


def check_compiled_forms() -> list[Finding]:
    """Check in which form that runs which is written in C and in Python; the results of both are equal."""
    topics = {
        "physics steps": "joints.native",
        "distances": "sensors.distance.native",
        "rays": "sensors.proximity.native",
        "inverse kinematics": "kinematics.least_squares.native",
        "V-REP's compression": "scene.formats.vrep.native",
    }
    return [_check_form(topic, f"simx_server.{package}.loading") for topic, package in topics.items()]


def _check_form(topic: str, module: str) -> Finding:
    try:
        found = import_module(module).form()
    except ImportError as error:
        return Finding(WARNING, topic, f"not known: {error}")
    if found.module is not None:
        return Finding(OK, topic, found.reason)
    advice = (
        f"{HOW_TO_COMPILE}; results are equal without, and slower: physics steps up to five times, inverse kinematics "
        "a hundred times"
    )
    return Finding(WARNING, topic, f"in Python: {found.reason}", advice)


def _available_memory() -> int | None:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    found = {name: int(rest.split()[0]) << 10 for name, _, rest in (line.partition(":") for line in lines)}
    return found.get("MemAvailable")


def check_workspace(folder: Path) -> Finding:
    """Check the only folder where clients may write."""
    try:
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".simx-doctor-"):
            free = shutil.disk_usage(folder).free
    except OSError as error:
        text = f"{folder} may not be written to ({error.strerror}), so clients cannot save files there"
        return Finding(WARNING, "workspace", text, "name another folder with --workspace FOLDER")
    if free < LEAST_DISK:
        text = f"{folder} has {free >> 20} MB left"
        return Finding(
            WARNING, "workspace", text, "make room, or name another folder with --workspace FOLDER"
        )
    return Finding(OK, "workspace", f"{folder} can be written to")
