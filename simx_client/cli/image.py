"""Implement ``python -m simx_client image CAMERA FILE.png``: save the image of a vision sensor, top row
first."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from simx_client.errors import SimxError
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, USAGE
from simx_client.protocol.commands import BY_NAME

from . import connecting
from .command_parser import command_parser
from .one_call import ask, handle_of
from .values.png import png, samples_16

EXAMPLES = """\
examples:
  python -m simx_client image kinect_rgb out.png
  python -m simx_client image kinect_depth depth.png --depth
Depths are grey of 16 bits: 0 is the near clipping plane, 65535 the far one, linear between.
exit codes: 0 the file is written, 1 it is not, 2 wrong usage
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser("image", "Write the image of a vision sensor into a PNG file.", examples=EXAMPLES)
    parser.add_argument("camera", metavar="CAMERA", help="name, path or handle of a vision sensor")
    parser.add_argument(
        "file", metavar="FILE.png", type=Path, help="file to write; an existing one is replaced"
    )
    parser.add_argument("--depth", action="store_true", help="write depths instead of colours")
    connecting.add_flags(parser)
    return parser


def main(argv: Sequence[str]) -> int:
    """Fetch and write the image; return the exit code."""
    options = make_parser().parse_args(argv)
    if options.file.suffix.lower() != ".png":
        sys.stderr.write(
            f"{options.file} is no name of a PNG file, which is all that is written; call it FILE.png\n"
        )
        return USAGE
    try:
        with connecting.connected(options.at, options.timeout) as (client, _):
            name = options.camera
            handle = int(name) if name.isdecimal() else handle_of(client, "simxGetObjectHandle", name)
            width, height, data = _depth(client, handle) if options.depth else _colours(client, handle)
        options.file.write_bytes(data)
    except SimxError as error:
        sys.stderr.write(f"{error}\n")
        return FAILURE
    except OSError as error:
        sys.stderr.write(
            f"{options.file} cannot be written: {error.strerror}; name a file in a folder of yours\n"
        )
        return FAILURE
    if options.json:
        record = {"file": str(options.file), "width": width, "height": height, "depth": options.depth}
        sys.stdout.write(json.dumps(record) + "\n")
    else:
        sys.stdout.write(f"{options.file}: {width}x{height}\n")
    return DONE


def _colours(client: int, handle: int) -> tuple[int, int, bytes]:
    (width, height), image = ask(client, BY_NAME["simxGetVisionSensorImage"], [handle, 0])
    rows = _top_first(image.tobytes(), height)
    return width, height, png(rows, width, height, is_colour=image.channels == 3)


def _depth(client: int, handle: int) -> tuple[int, int, bytes]:
    (width, height), depths = ask(client, BY_NAME["simxGetVisionSensorDepthBuffer"], [handle])
    rows = _top_first(samples_16(depths), height)
    return width, height, png(rows, width, height, is_colour=False, bits=16)


def _top_first(data: bytes, height: int) -> list[bytes]:
    """Return the rows of an image, received bottom row first, with the top row first."""
    length = len(data) // max(1, height)
    return [data[row * length : (row + 1) * length] for row in reversed(range(height))]
