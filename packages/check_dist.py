"""Check a folder of distributions as a whole: ``python packages/check_dist.py FOLDER``.

It has both packages in one version, each as wheels and as a source archive; small files; no compiled file in an
archive. The wheel of this machine is installed from the index into a fresh environment and used (`try_wheel.py`).
"""

from __future__ import annotations

import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

MOST = 12 << 20
"""Bytes of a distribution; the index refuses 100 MB, and a user of the whole waits for MuJoCo, not for this."""

COMPILED = (".so", ".pyd", ".dylib", ".dll", ".pyc", ".o")
MODULES = len(list(Path(__file__).parents[1].glob("simx_server/**/native/*.c")))
"""Compiled modules of a wheel for one kind of machine."""

TOP = {"simx_server", "simx_client", "simx_pyrep.pth"}
"""What a wheel may put into an environment, beside its own metadata."""


def problems(folder: Path) -> list[str]:
    """Return what is wrong with the files of a folder."""
    files = sorted(path for path in folder.iterdir() if path.suffix in (".whl", ".gz"))
    found = {(name, kind) for name, _, kind in map(_parts, files)}
    wrong = [
        f"there is no {kind} of {name}"
        for name in ("simx_vrep", "simx_vrep_client")
        for kind in ("whl", "gz")
        if (name, kind) not in found
    ]
    versions = sorted({version for _, version, _ in map(_parts, files)})
    if len(versions) > 1:
        wrong.append(f"there are several versions: {', '.join(versions)}")
    for file in files:
        wrong += [f"{file.name}: {each}" for each in _of_file(file)]
    return wrong


def _parts(file: Path) -> tuple[str, str, str]:
    name, version = file.name.removesuffix(".tar.gz").split("-")[:2]
    return name, version, file.suffix[1:]


def _of_file(file: Path) -> list[str]:
    wrong = [f"{file.stat().st_size >> 20} MB, more than {MOST >> 20}"] if file.stat().st_size > MOST else []
    if file.suffix == ".gz":
        with tarfile.open(file) as archive:
            return wrong + [f"has {name}" for name in archive.getnames() if name.endswith(COMPILED)]
    with zipfile.ZipFile(file) as archive:
        names = archive.namelist()
    top = {name.partition("/")[0] for name in names}
    wrong += [
        f"puts {name} into environments" for name in sorted(top - TOP) if not name.endswith(".dist-info")
    ]
    modules = sum(name.endswith((".so", ".pyd")) for name in names)
    if modules != (MODULES if "-abi3-" in file.name else 0):
        wrong.append(f"has {modules} compiled modules")
    return wrong


def of_this_machine(folder: Path) -> Path | None:
    """Return the wheel of the whole for this machine, if there is one."""
    system = re.sub(r"[.-]", "_", sysconfig.get_platform())
    kind, machine = system.partition("_")[0], system.rpartition("_")[2]
    wheels = folder.glob("simx_vrep-*.whl")
    return next((each for each in wheels if kind in each.name and machine in each.name), None)


def main(folder: Path) -> int:
    """Print what is wrong; return 1 if something is."""
    if wrong := problems(folder):
        sys.stderr.write("\n".join(wrong) + "\n")
        return 1
    if wheel := of_this_machine(folder):
        with tempfile.TemporaryDirectory() as place:
            venv.create(place, with_pip=True)
            programs = Path(place, "Scripts" if sys.platform == "win32" else "bin")
            pip = [programs / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
            subprocess.run([*pip, wheel], check=True)
            subprocess.run([programs / "python", Path(__file__).with_name("try_wheel.py")], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
