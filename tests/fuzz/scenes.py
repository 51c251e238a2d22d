"""Scene files that mean no good: MJCF with its `<custom>` annotations, and URDF, cut up and put together again.

`one` makes a text of any bytes: they say which pieces of good scenes are taken, left out, doubled or given another
value. A scene that loads runs for a moment. MuJoCo parses in this process, so a fault in MuJoCo ends it: the driver starts
another one and tells.
"""

# ruff: noqa: E501 - long lines are lists of values and commands

from __future__ import annotations

import re
from pathlib import Path

from simx_server.app.building import build_world
from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.scene.formats.annotations import GRAMMAR
from simx_server.scene.formats.loader import load_scene
from simx_server.sensors.rendering.render_thread import RenderThread

from .codec import Bytes
from .scene import SCENE

URDF = """<robot name="r"><link name="a"><visual><geometry><box size="1 1 1"/></geometry></visual>
<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""

MORE = """<mujoco><option timestep="0.01" integrator="RK4"/><compiler angle="radian"/><default><geom rgba="1 0 0 1"/>
<joint damping="1"/></default><asset><texture name="t" type="2d" builtin="checker" width="8" height="8"/>
<material name="m" texture="t"/><hfield name="h" nrow="3" ncol="3" size="1 1 1 1"/>
<mesh name="k" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset><worldbody><geom type="hfield" hfield="h"/>
<body name="a"><joint name="j1"/><geom type="mesh" mesh="k" material="m"/><site name="s1"/><body name="b" pos="1 0 0">
<joint name="j2" axis="0 1 0"/><geom size="1"/><site name="s2"/></body></body><body name="c" mocap="true"><geom size="1"/></body>
</worldbody><tendon><spatial name="t1"><site site="s1"/><site site="s2"/></spatial><fixed name="t2"><joint joint="j1" coef="1"/>
</fixed></tendon><actuator><position name="p" joint="j1" kp="3"/><motor joint="j2"/><velocity tendon="t1"/></actuator>
<equality><joint joint1="j1" joint2="j2"/><weld body1="a" body2="c"/></equality><contact><exclude body1="a" body2="b"/></contact>
<sensor><jointpos joint="j1"/><accelerometer site="s1"/></sensor><keyframe><key qpos="0 0"/></keyframe></mujoco>"""

_PIECE = re.compile(r"<[^<>]*>|[^<>]+")
_VALUE = re.compile(r'"[^"]*"')
POOL: tuple[str, ...] = tuple(piece for text in (SCENE, MORE, URDF) for piece in _PIECE.findall(text))
KEYS = sorted({key for keys in GRAMMAR.values() for key in keys})
VALUES = (
    "", "0", "-1", "1e308", "nan", "inf", "-inf", "1 2", "1 2 3 4 5 6 7", "99999999999999999999", "1e-300", "a", "base", "arm", "hinge",
    "all", "true", "yes", "..", "/etc/passwd", "\N{ROBOT FACE}", "\udc80", "%s", "x" * 3000, "simx:", "mesh", "free", "ball", "box", "2147483647", "-0",
    "self", "world", "&#10;", "&amp;", "&#0;",
)  # fmt: skip
NUMBERS = (
    "0",
    "-1",
    "1",
    "360",
    "400",
    "nan",
    "inf",
    "1e308",
    "1e-308",
    "",
    "a",
    "yes",
    "force",
    "arm",
    "arm,box",
    ",",
    "self",
)


def text_of(data: bytes) -> str:
    """A scene file out of any bytes."""
    source = Bytes(data)
    pieces = _PIECE.findall((SCENE, MORE, URDF)[source.number(3)])
    while not source.is_used_up:
        what, at = source.number(8), int.from_bytes(source.take(2), "little") % max(1, len(pieces))
        other = POOL[int.from_bytes(source.take(2), "little") % len(POOL)]
        if what == 0 and pieces:
            del pieces[at]
        elif what == 1:
            pieces.insert(at, other)
        elif what == 2 and pieces:
            pieces.insert(at, pieces[at])
        elif what in (3, 4) and pieces:
            found = list(_VALUE.finditer(pieces[at]))
            if found:
                place = found[source.number(len(found))]
                new = VALUES[source.number(len(VALUES))]
                pieces[at] = f'{pieces[at][: place.start()]}"{new}"{pieces[at][place.end() :]}'
        elif what == 5 and pieces:
            attributes = re.findall(r'\s[\w:]+="[^"]*"', other)
            if attributes and pieces[at].endswith(">"):
                end = -2 if pieces[at].endswith("/>") else -1
                pieces[at] = pieces[at][:end] + attributes[source.number(len(attributes))] + pieces[at][end:]
        elif what >= 6:
            kinds = [*GRAMMAR, "", "no"]
            name = (
                "arm",
                "hinge",
                "slide",
                "eye",
                "ray",
                "feel",
                "base",
                "box",
                "dummy",
                "new",
                "main",
                "a:b",
                "",
            )[source.number(13)]
            words = " ".join(
                f"{KEYS[source.number(len(KEYS))]}={NUMBERS[source.number(len(NUMBERS))]}"
                for _ in range(source.number(4))
            )
            pieces.insert(
                1,
                f'<custom><text name="simx:{kinds[source.number(len(kinds))]}:{name}" data="{words or "x"}"/></custom>',
            )
    return "".join(pieces)


class Loader:
    """A simulation that every text is loaded into."""

    def __init__(self, folder: Path) -> None:
        self._rendering = RenderThread()  # no image is asked for, so it begins nothing
        self.parts = build_world(self._rendering, workspace=folder)
        self.sim = self.parts.simulation
        self.file = folder / "hostile.xml"
        self.loaded = 0

    def one(self, data: bytes) -> None:
        """One case: it loads and runs, or is refused with a sentence."""
        self.file.write_bytes(text_of(data).encode("utf-8", "surrogateescape"))
        try:
            scene, model = load_scene(self.file)
        except CommandError as error:
            assert str(error), "no sentence"  # noqa: PT017 - no test, but what tests call
            return
        try:
            self.sim.use(scene, model)
            self.sim.start()
            self.parts.step()
        except (CommandError, LimitReached):
            pass
        finally:
            self.sim.stop()
        self.loaded += 1

    def close(self) -> None:
        self.parts.scripts.close()
