"""Bodies that are deleted together leave what bodies leave that are deleted one by one."""

from __future__ import annotations

import random

import mujoco
import numpy as np
import pytest
from seeds import seeds

from simx_server.scene.editing.transplant import delete, delete_all


def spec() -> mujoco.MjSpec:
    """Trees of moving bodies, some of them in frames, beside bodies that stand still."""
    trees = "".join(
        f'<frame pos="0 0 {i}"><body name="a{i}" childclass="red" pos="{i} 0 0"><freejoint/><geom size=".1"/>'
        f'<site name="s{i}"/><body name="b{i}"><joint name="j{i}"/><geom size=".1"/><body name="c{i}"><geom size=".1"/>'
        f'</body><body name="d{i}"><geom size=".1"/></body></body></body></frame>'
        f'<body name="e{i}"><geom size=".1"/></body>'
        for i in range(12)
    )
    motors = "".join(f'<motor name="m{i}" joint="j{i}"/>' for i in range(12))
    return mujoco.MjSpec.from_string(
        f'<mujoco><default><default class="red"><geom rgba="1 0 0 1"/></default></default>'
        f"<worldbody>{trees}</worldbody><actuator>{motors}</actuator>"
        '<sensor><framepos objtype="site" objname="s3"/></sensor></mujoco>'
    )


def written(changed: mujoco.MjSpec) -> tuple[bytes, str]:
    model = changed.compile()
    numbers = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, numbers)
    return numbers.tobytes(), changed.to_xml()


@pytest.mark.parametrize("seed", seeds(8))
def test_many_at_once_are_as_one_after_the_other(seed: int) -> None:
    choose = random.Random(seed)
    names = choose.sample([f"{kind}{i}" for kind in "abcde" for i in range(12)], choose.randint(2, 20))
    together, apart = spec(), spec()
    delete_all(together, [("body", name) for name in (*names, names[0])])
    for name in names:
        delete(apart, "body", name)
    assert not any(together.body(name) for name in names)
    assert written(together) == written(apart)
