"""Use an installed simx-vrep as a stranger would: ``python packages/try_wheel.py`` in an environment that has it.

It fails if a compiled module is not used, or if an old script does not drive a shipped scene. cibuildwheel runs it with
each wheel, and `make check-dist` with that of this machine. Standard library only.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path

FORMS = (
    "joints.native",
    "sensors.distance.native",
    "sensors.proximity.native",
    "kinematics.least_squares.native",
    "scene.formats.vrep.native",
)

OLD_SCRIPT = """
import vrep
cid = vrep.simxStart("127.0.0.1", 19997, True, True, 20000, 5)
code, joint = vrep.simxGetObjectHandle(cid, "UR5_joint1", vrep.simx_opmode_blocking)
print(cid, code, *vrep.simxGetJointPosition(cid, joint, vrep.simx_opmode_blocking))
vrep.simxFinish(cid)
"""


def main() -> int:
    """Return 1, with the reason on standard error, if something does not work."""
    for package in FORMS:
        form = import_module(f"simx_server.{package}.loading").form()
        if form.module is None:
            sys.stderr.write(f"{package}: {form.reason}\n")
            return 1
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder, "old.py")
        script.write_text(OLD_SCRIPT, encoding="utf-8")
        command = [sys.executable, "-m", "simx_client", "run", "--server", "ur5", str(script)]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    if done.returncode or done.stdout.split()[:3] != ["0", "0", "0"]:
        sys.stderr.write(
            f"an old script printed {done.stdout!r} and ended with {done.returncode}: {done.stderr}\n"
        )
        return 1
    sys.stdout.write("compiled modules are used, and an old script drives a shipped scene\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
