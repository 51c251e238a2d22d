"""Scripts write and read image files of the workspace."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

PICTURE = "image = string.char(255,0,0, 0,255,0, 0,0,255, 1,2,3, 4,5,6, 7,8,9)\n"
"""Three columns, two rows."""


def test_an_image_is_written_and_read_again(world: ScriptWorld, tmp_path: Path) -> None:
    assert world.lua(PICTURE + "return sim.saveImage(image, {3, 2}, 0, 'made/small.png', -1)") == [1]
    pixels = cv2.imread(str(tmp_path / "made" / "small.png"))
    assert pixels is not None
    assert pixels.shape == (2, 3, 3)
    assert pixels[0, 0].tolist() == [0, 0, 255]
    assert world.lua("back, size = sim.loadImage(0, 'made/small.png') return back == image, size") == [
        True,
        [3, 2],
    ]
    assert world.lua("back = sim.loadImage(1, 'made/small.png') return #back, back:byte(4)") == [24, 255]


@pytest.mark.parametrize(
    ("file", "head"), [("", "89504e47"), (".png", "89504e47"), (".JPG", "ffd8ff"), (".bmp", "424d")]
)
def test_an_ending_alone_gives_the_files_content(world: ScriptWorld, file: str, head: str) -> None:
    (content,) = world.lua(PICTURE + f"data = sim.saveImage(image, {{3, 2}}, 0, '{file}', 100) return data")
    assert content.encode("latin-1").hex().startswith(head)
    assert world.lua("return select(2, sim.loadImage(0, data .. '@mem'))") == [[3, 2]]


def test_transparency_is_kept_in_png(world: ScriptWorld) -> None:
    world.lua("rgba = string.char(1,2,3,4, 5,6,7,8) file = sim.saveImage(rgba, {2, 1}, 1, '.png')")
    source = "return sim.loadImage(1, file .. '@mem') == rgba"
    assert world.lua(source) == [True]


def test_grey_and_deep_images_are_read(world: ScriptWorld, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "deep.png"), np.array([[0x1234, 0xFFFF]], np.uint16))
    assert world.lua("return (sim.loadImage(0, 'deep.png')):byte(1, 6)") == [0x12] * 3 + [0xFF] * 3


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        ("sim.saveImage('abc', {2, 1}, 0, 'a.png')", "has 6 bytes, not 3"),
        ("sim.saveImage('abc', {1, 1}, 0, 'a.txt')", "does not end like an image file"),
        ("sim.saveImage('abc', {1, 1}, 0, '../a.png')", "without '..'"),
        ("sim.saveImage('', {0, 1}, 0, 'a.png')", "a resolution is"),
        ("sim.saveImage('', {99999, 99999}, 0, 'a.png')", "a resolution is"),
        ("sim.loadImage(0, 'missing.png')", "no file 'missing.png'"),
        ("sim.loadImage(0, '/etc/passwd')", "is not allowed"),
        ("sim.loadImage(0, 'nonsense@mem')", "not an image file"),
    ],
)
def test_a_wrong_file_or_image_is_refused(world: ScriptWorld, call: str, problem: str) -> None:
    world.fails(call, problem)


@pytest.mark.parametrize(
    "data",
    [
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 60000, 60000),
        b"BM" + bytes(16) + struct.pack("<ii", 60000, -60000),
        b"\xff\xd8\xff\xe0\x00\x02\xff\xff\xc0\x00\x11\x08" + struct.pack(">HH", 60000, 60000),
    ],
)
def test_an_image_that_says_it_is_huge_is_not_read(world: ScriptWorld, tmp_path: Path, data: bytes) -> None:
    (tmp_path / "bomb.png").write_bytes(data)
    world.fails("sim.loadImage(0, 'bomb.png')", "60000 x 60000 pixels")
    (tmp_path / "bomb.png").write_bytes(data.replace(struct.pack(">I", 60000), b"\0\0\0\2")[:24])
    world.fails("sim.loadImage(0, 'bomb.png')", "damaged|not an image file|60000")


def test_images_are_scaled_as_the_options_say(world: ScriptWorld) -> None:
    world.lua("image = string.rep(string.char(10, 20, 30), 4 * 2)")
    assert world.lua("out, size = sim.getScaledImage(image, {4, 2}, {8, 6}, 0) return #out, size") == [
        8 * 6 * 3,
        [8, 6],
    ]
    assert world.lua("return out:byte(1, 3)") == [10, 20, 30]
    assert world.lua("return select(2, sim.getScaledImage(image, {4, 2}, {8, 8}, 4))") == [[8, 4]]
    assert world.lua("return select(2, sim.getScaledImage(image, {4, 2}, {8, 8}, 8))") == [[16, 8]]
    assert world.lua("return (sim.getScaledImage(image, {4, 2}, {1, 1}, 2)):byte(1, 4)") == [10, 20, 30, 255]
    world.lua("rgba = string.rep(string.char(1, 2, 3, 4), 4)")
    assert world.lua("return (sim.getScaledImage(rgba, {2, 2}, {1, 1}, 1)):byte(1, 4)") == [1, 2, 3]
    assert world.lua("return (sim.getScaledImage(rgba, {2, 2}, {1, 1}, 3)):byte(1, 4)") == [1, 2, 3, 4]
    two = "string.char(0, 0, 0, 200, 200, 200)"
    assert world.lua(f"return (sim.getScaledImage({two}, {{2, 1}}, {{4, 1}}, 16)):byte(4)") == [0]
    assert world.lua(f"return (sim.getScaledImage({two}, {{2, 1}}, {{1, 1}}, 0)):byte(1)") == [100]
    world.fails("sim.getScaledImage('abc', {2, 2}, {1, 1}, 0)", "2 x 2 pixels are 12 bytes, not 3")
    world.fails("sim.getScaledImage(image, {4, 2}, {99999, 99999}, 0)", "a resolution is")


def test_two_images_become_one(world: ScriptWorld) -> None:
    world.lua("one, two = string.char(1, 1, 1), string.char(2, 2, 2, 3, 3, 3)")
    below = "sim.combineRgbImages(two, {2, 1}, two, {2, 1}, sim.imgcomb_vertical)"
    beside = "sim.combineRgbImages(one, {1, 1}, two, {2, 1}, sim.imgcomb_horizontal)"
    assert world.lua(f"return ({below}):byte(1, -1)") == [2, 2, 2, 3, 3, 3] * 2
    assert world.lua(f"return ({beside}):byte(1, -1)") == [1, 1, 1, 2, 2, 2, 3, 3, 3]
    world.fails(
        "sim.combineRgbImages(one, {1, 1}, two, {2, 1}, sim.imgcomb_vertical)", "the same width, not 1 and 2"
    )
    world.fails("sim.combineRgbImages(one, {1, 1}, one, {1, 1}, 7)", "the operation is sim.imgcomb_vertical")


def test_in_lua_an_image_is_mirrored_in_place(world: ScriptWorld) -> None:
    world.lua("image, long = 'abcdef', string.rep('abcdef', 20) other = string.rep('abcdef', 20)")
    world.lua("sim.transformImage(long, {2, 20}, 2)")
    assert world.lua("return long == string.rep('defabc', 20), other == string.rep('abcdef', 20)") == [
        True,
        True,
    ]
    source = """
    local mine = string.rep('abcdef', 20)
    local function flip() sim.transformImage(mine, {2, 20}, 2) return mine:sub(1, 3) end
    local flipped = flip()
    sim.transformImage(mine, {2, 20}, 2)
    return flipped, mine:sub(1, 3)
    """
    assert world.lua(source) == ["def", "abc"]
