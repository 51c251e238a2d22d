"""Draw RLBench's tasks into one image: ``python tests/pyrep/gallery.py PATH OUT.png [TASK ...]``.

PATH is a checkout of RLBench, with PyRep installed or on PYTHONPATH. Each task is shown by the front camera after a
reset. RLBench's licence covers the models, so we ship no such image.
"""

# pyright: reportMissingImports=false, reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false
from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from run_rlbench import with_base_scene

import simx_client.pyrep

TASKS = ("close_box", "open_drawer", "phone_on_base", "pick_up_cup", "push_button", "reach_target",
         "stack_blocks", "take_lid_off_saucepan")  # fmt: skip
SIZE = 256
"""Pixels of the edge of a task's image."""

COLUMNS = 4


def views(names: Sequence[str]) -> Iterator[Any]:
    """Yield the image of each task, (SIZE, SIZE, 3) bytes."""
    from rlbench.action_modes.action_mode import MoveArmThenGripper
    from rlbench.action_modes.arm_action_modes import JointVelocity
    from rlbench.action_modes.gripper_action_modes import Discrete
    from rlbench.environment import Environment
    from rlbench.observation_config import ObservationConfig
    from rlbench.utils import name_to_task_class

    observed = ObservationConfig()
    observed.set_all(False)
    observed.front_camera.rgb, observed.front_camera.image_size = True, (SIZE, SIZE)
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    environment = Environment(mode, obs_config=observed, headless=True)
    environment.launch()
    try:
        for name in names:
            _, observation = environment.get_task(name_to_task_class(name)).reset()
            yield observation.front_rgb
    finally:
        environment.shutdown()


def sheet(images: Sequence[Any]) -> Any:
    """Return images of equal size in rows of COLUMNS; places without one are black."""
    rows = math.ceil(len(images) / COLUMNS)
    blank = [np.zeros_like(images[0])] * (rows * COLUMNS - len(images))
    cells = np.stack([*images, *blank]).reshape(rows, COLUMNS, *images[0].shape)
    return np.vstack([np.hstack(row) for row in cells])


def main() -> int:
    """Write the image."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("checkout", metavar="PATH", type=Path)
    parser.add_argument("out", metavar="OUT.png", type=Path)
    parser.add_argument("tasks", metavar="TASK", nargs="*", default=TASKS)
    options = parser.parse_args()
    simx_client.pyrep.activate()
    sys.path.insert(0, str(options.checkout.resolve()))
    with_base_scene(options.checkout.resolve() / "rlbench")
    from PIL import Image

    Image.fromarray(sheet(list(views(options.tasks)))).save(options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
