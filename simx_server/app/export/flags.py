"""The flags that choose what datasets contain."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from simx_server.datasets.wanted import Light, Wanted


def add_choice(parser: argparse.ArgumentParser) -> None:
    """Add the flags that choose what datasets contain."""
    group = parser.add_argument_group("contents of --npz, --lerobot and --minari")
    group.add_argument(
        "--observe",
        metavar="NAME",
        nargs="+",
        default=[],
        help="UR5_joint1.position, Cube.quaternion, ... (joints that move, and free bodies)",
    )
    group.add_argument(
        "--act",
        metavar="NAME",
        nargs="+",
        default=[],
        help="UR5_joint1.target_position, RG2_open.int_signal, ... (what the motors obey)",
    )
    group.add_argument(
        "--cameras",
        metavar="NAME[:WxH]",
        nargs="+",
        default=[],
        type=_checked(Wanted.parse, "NAME or NAME:WxH, such as kinect_rgb:128x96; overview shows all"),
        help="images of cameras and vision sensors, in any size; overview shows all",
    )
    group.add_argument(
        "--light",
        metavar="X[,AZ,EL]",
        default=Light(),
        type=_checked(Light.parse, "0.5 for half the brightness, or with a direction in degrees 1,90,30"),
        help="light of the images: brightness, and in degrees from where it shines (1)",
    )
    group.add_argument("--successes", action="store_true", help="only episodes that are marked as a success")
    group.add_argument("--task", metavar="TEXT", help="what is shown, in words (the scene's name)")


def _checked(parse: Callable[[str], Any], valid: str) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            return parse(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} cannot be used; valid: {valid}") from None

    return read
