"""A package of a user's own messages, as files."""

from __future__ import annotations

from pathlib import Path

PACKAGE = "my_robot"
FILES = {
    "msg/Wheel.msg": "# One wheel.\nuint8 LEFT=0\nuint8 RIGHT=1\nuint8 side\nfloat32 speed 0.5  # rad/s\n",
    "msg/Status.msg": (
        'string DEFAULT_NAME="robby # 1"\nstd_msgs/Header header\nstring<=20 name "robby"\nWheel[] wheels\n'
        "my_robot/Wheel[2] both\nfloat64[<=3] limits [0.5, 1.5]\nbool is_ready true\nstring[] notes\n"
    ),
    "srv/SetName.srv": "string<=20 name\nuint32 times 2\n---\nbool success\nstring message\n",
    "action/Drive.action": "float64 metres\n---\nbool arrived\n---\nfloat64 driven\n",
}
STATUS, SET_NAME, DRIVE = f"{PACKAGE}/msg/Status", f"{PACKAGE}/srv/SetName", f"{PACKAGE}/action/Drive"


def write_package(root: Path, name: str = PACKAGE, files: dict[str, str] | None = None) -> Path:
    """Write a package below a folder; return its own folder, whose name differs from that of the package."""
    folder = root / "src" / f"{name}_files"
    for path, text in (files or FILES).items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>", encoding="utf-8")
    return folder
