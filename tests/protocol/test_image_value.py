"""The image and depth values: real lists for old scripts, arrays for NumPy, never stale."""

import array
import copy
import itertools
import json
import pickle
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simx_client.calls.images import DepthBuffer, VisionImage

WIDTH, HEIGHT = 4, 3
RECEIVED = bytes((7 * i + 120) % 256 for i in range(WIDTH * HEIGHT * 3))
SIGNED = [value - 256 if value > 127 else value for value in RECEIVED]
PIXELS = np.frombuffer(RECEIVED, np.uint8)


def make(state: str = "unread") -> VisionImage:
    image = VisionImage.from_bytes(RECEIVED, WIDTH, HEIGHT)
    if state in ("read", "edited"):
        assert image[0] == SIGNED[0]
    if state == "edited":
        image[0] = image[0]
    return image


each_state = pytest.mark.parametrize("state", ["unread", "read", "edited"])


@each_state
def test_image_is_a_list_of_signed_ints(state: str) -> None:
    image = make(state)
    assert isinstance(image, list)
    assert isinstance(image, VisionImage)
    assert len(image) == len(SIGNED)
    assert bool(image)
    assert image == SIGNED
    plain = list(SIGNED)
    assert plain == image
    assert all(type(value) is int for value in image)


READERS = {
    "index": lambda x: [x[i] for i in range(len(x))],
    "every third": lambda x: [x[i] for i in range(0, len(x), 3)],
    "slice": lambda x: x[3:9],
    "extended slice": lambda x: x[::3],
    "negative index": lambda x: x[-1],
    "iteration": lambda x: [value for value in x],  # noqa: C416 - the loop is what is tested
    "map": lambda x: list(map(abs, x)),
    "reversed": lambda x: list(reversed(x)),
    "contains": lambda x: (SIGNED[5] in x, 300 in x),
    "index of": lambda x: x.index(SIGNED[5]),
    "count": lambda x: x.count(SIGNED[5]),
    "copy": lambda x: x.copy(),
    "add": lambda x: [*(x + [1]), *([1] + x)],  # noqa: RUF005 - the operators are what is tested
    "multiply": lambda x: (x * 2, 2 * x),
    "compare": lambda x: (x < [0], x <= [0], x > [0], x >= [0]),
    "repr": repr,
    "sum": sum,
    "minimum": min,
    "sorted": sorted,
    "list": list,
    "tuple": tuple,
    "unpacked": lambda x: [*x],
    "chain": lambda x: list(itertools.chain([], x)),
    "array('b')": lambda x: array.array("b", x).tobytes(),
    "fromiter": lambda x: np.fromiter(x, np.int64).tolist(),
    "struct": lambda x: struct.pack(f"{len(x)}b", *x),
    "json": json.dumps,
}


@each_state
@pytest.mark.parametrize("reader", READERS)
def test_image_reads_like_a_plain_list(state: str, reader: str) -> None:
    assert READERS[reader](make(state)) == READERS[reader](list(SIGNED))


EDITORS = {
    "item": lambda x: x.__setitem__(2, 99),
    "slice": lambda x: x.__setitem__(slice(0, 3), [1, 2, 3]),
    "delete": lambda x: x.__delitem__(0),
    "append": lambda x: x.append(5),
    "extend": lambda x: x.extend([5, 6]),
    "insert": lambda x: x.insert(0, 5),
    "pop": lambda x: x.pop(),
    "remove": lambda x: x.remove(SIGNED[3]),
    "clear": lambda x: x.clear(),
    "sort": lambda x: x.sort(),
    "reverse": lambda x: x.reverse(),
    "+=": lambda x: x.__iadd__([5]),
    "*=": lambda x: x.__imul__(2),
}


@each_state
@pytest.mark.parametrize("editor", EDITORS)
def test_every_edit_is_seen_by_the_next_array(state: str, editor: str) -> None:
    image, plain = make(state), list(SIGNED)
    assert EDITORS[editor](image) == EDITORS[editor](plain)
    assert image == plain
    assert np.array(image).tolist() == plain
    if plain:
        assert np.array(image, dtype=np.uint8).tolist() == [value % 256 for value in plain]
    assert image.tobytes() == bytes(value % 256 for value in plain)


def test_no_method_of_list_is_forgotten() -> None:
    harmless = {
        "__getattribute__",
        "__class_getitem__",
        "__init__",
        "__len__",
        "__hash__",
        "__sizeof__",
        "__new__",
    }
    ours = {name for cls in type(make()).__mro__ if cls not in (list, object) for name in vars(cls)}
    assert vars(list).keys() - harmless - {"__doc__"} <= ours


@pytest.mark.parametrize("one", ["unread", "read", "edited"])
@each_state
def test_two_images_compare_and_join(one: str, state: str) -> None:
    assert make(one) == make(state)
    assert (make(one) != make(state)) is False
    assert make(one) + make(state) == SIGNED + SIGNED
    image = make(one)
    image += make(state)
    image[3:3] = make(state)
    assert image == SIGNED[:3] + SIGNED + SIGNED[3:] + SIGNED


@each_state
def test_uint8_conversion_wraps_and_resizes_in_place(state: str) -> None:
    picture = np.array(make(state), dtype=np.uint8)
    picture.resize([HEIGHT, WIDTH, 3])
    assert picture.dtype == np.uint8
    assert (picture.ravel() == PIXELS).all()
    picture[0, 0] = 0  # its own memory: writable, and the image is not touched
    assert make(state) == SIGNED


@each_state
def test_array_without_a_type_is_int64_so_that_adding_256_works(state: str) -> None:
    picture = np.array(make(state))
    assert picture.dtype == np.int64
    assert picture.shape == (len(SIGNED),)
    picture[picture < 0] += 256
    assert (picture.astype(np.uint8) == PIXELS).all()
    assert (np.array(make(state)).astype(np.uint8).reshape(HEIGHT, WIDTH, 3)[0, 0] == PIXELS[:3]).all()


@each_state
def test_adding_128_to_a_float_image_works(state: str) -> None:
    picture = np.array(make(state), dtype=float) + 128
    assert picture.min() >= 0
    assert picture[0] == SIGNED[0] + 128


@each_state
def test_sign_put_right_in_the_list_itself(state: str) -> None:
    image = make(state)
    for i in range(len(image)):
        if image[i] < 0:
            image[i] += 256
    assert image == list(RECEIVED)
    assert (np.array(image, dtype=np.uint8) == PIXELS).all()
    assert (image.array.ravel() == PIXELS).all()


@each_state
def test_the_channel_by_channel_tutorial_idiom(state: str) -> None:
    image = make(state)
    red = np.array([image[i] for i in range(0, len(image), 3)]).reshape(HEIGHT, WIDTH).astype(np.uint8)
    assert (red == image.array[:, :, 0]).all()


def test_array_is_a_read_only_view_of_the_bytes() -> None:
    received = bytearray(RECEIVED)
    image = VisionImage.from_bytes(memoryview(received), WIDTH, HEIGHT)
    view = image.array
    assert view.shape == (HEIGHT, WIDTH, 3)
    assert view.dtype == np.uint8
    assert np.shares_memory(view, np.frombuffer(received, np.uint8))
    grey = VisionImage.from_bytes(RECEIVED[:12], WIDTH, HEIGHT, 1)
    assert grey.array.shape == (HEIGHT, WIDTH)
    assert not make().array.flags.writeable


def test_upright_has_the_top_row_first() -> None:
    assert (make().upright()[0] == make().array[-1]).all()


def test_a_writable_buffer_is_not_writable_through_the_view() -> None:
    image = VisionImage.from_bytes(bytearray(RECEIVED), WIDTH, HEIGHT)
    with pytest.raises(ValueError, match="read-only"):
        image.array[0] = 0


def test_numpy_users_never_pay_for_the_list() -> None:
    image = make()
    unread = type(image)
    np.array(image)
    np.asarray(image, dtype=np.uint8)
    assert image.array.size == len(image)
    image.upright()
    image.tobytes()
    assert type(image) is unread
    assert image[0] == SIGNED[0]
    assert type(image) is not unread


def test_consumers_that_read_list_memory_fail_loudly_before_the_first_touch() -> None:
    with pytest.raises(TypeError):
        array.array("b").fromlist(make())
    values = array.array("b")
    values.fromlist(make("read"))
    assert values.tolist() == SIGNED


@pytest.mark.parametrize("kind", [VisionImage, DepthBuffer])
def test_a_list_made_while_an_image_was_waited_for_is_used_once_and_only_if_it_has_the_right_length(
    kind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    new = kind._new

    def counted(length: int) -> Any:
        made.append(length)
        return new(length)

    monkeypatch.setattr(kind, "_new", counted)

    def received(width: int) -> Any:
        size = width * (3 if kind is VisionImage else 4)
        return kind.from_bytes(bytes(range(size)), width, 1)

    first = received(2)
    received(2)
    kind.prepare()
    kind.prepare()
    assert made == [len(first)] * 3
    second, third = received(2), received(2)
    assert made == [len(first)] * 4
    assert second is not third
    assert list(first) == list(second) == list(third)
    second[0] = 5
    assert list(first) == list(third)
    kind.prepare()
    assert list(received(4))[: len(first)] == list(first)
    assert made == [len(first)] * 5 + [2 * len(first)]


@pytest.mark.parametrize("kind", [VisionImage, DepthBuffer])
def test_no_list_is_made_in_advance_where_images_of_two_sizes_take_turns(
    kind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    new = kind._new
    monkeypatch.setattr(kind, "_new", lambda length: made.append(length) or new(length))
    size = 3 if kind is VisionImage else 4
    lengths = [len(kind.from_bytes(bytes(width * size), width, 1)) for width in (5, 1)]
    for width in (5, 1, 5, 1):
        kind.prepare()
        kind.from_bytes(bytes(width * size), width, 1)
    assert made == lengths * 3


def test_copy_false_gives_a_view_or_says_why_not() -> None:
    image = make()
    view = image.__array__(np.uint8, copy=False)
    assert not view.flags.writeable
    assert (view == PIXELS).all()
    with pytest.raises(ValueError, match="without a copy"):
        image.__array__(copy=False)


def test_array_of_an_edited_image_that_lost_its_length_says_so() -> None:
    image = make()
    image.append(1)
    with pytest.raises(ValueError, match=f"edited to {len(SIGNED) + 1} values"):
        _ = image.array


def test_wrong_number_of_bytes_is_refused() -> None:
    with pytest.raises(ValueError, match="takes 36 bytes, got 35"):
        VisionImage.from_bytes(RECEIVED[:-1], WIDTH, HEIGHT)


def test_empty_image() -> None:
    image = VisionImage.from_bytes(b"", 0, 0)
    assert image == []
    assert len(image) == 0
    assert np.array(image, dtype=np.uint8).size == 0


def test_images_larger_than_one_conversion_step() -> None:
    data = bytes(range(256)) * 200
    image = VisionImage.from_bytes(data, 256, 200, 1)
    assert list(image) == np.frombuffer(data, np.int8).tolist()


@each_state
@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies_are_images_too(state: str, duplicate) -> None:
    image = make(state)
    twin = duplicate(image)
    assert isinstance(twin, VisionImage)
    assert twin == image
    assert (twin.array == image.array).all()
    twin[0] = 11
    assert image == SIGNED
    assert np.array(twin)[0] == 11


def test_several_images_stack() -> None:
    assert np.array([make(), make()]).shape == (2, len(SIGNED))


DEPTHS = np.linspace(0, 1, WIDTH * HEIGHT, dtype=np.float32)


def test_depth_buffer_is_a_list_of_floats_and_an_array() -> None:
    depth = DepthBuffer.from_bytes(DEPTHS.tobytes(), WIDTH, HEIGHT)
    assert depth.array.shape == (HEIGHT, WIDTH)
    assert depth.array.dtype == np.float32
    assert not depth.array.flags.writeable
    assert np.array(depth).dtype == np.float64
    assert depth == DEPTHS.tolist()
    assert type(depth[1]) is float
    assert isinstance(depth, list)
    assert (depth.upright()[0] == depth.array[-1]).all()
    depth[0] = 0.5
    assert np.array(depth)[0] == 0.5
    assert depth.array[0, 0] == 0.5
    assert depth.tobytes()[:4] == struct.pack("f", 0.5)


def test_values_work_without_numpy(tmp_path: Path) -> None:
    (tmp_path / "numpy.py").write_text("raise ImportError('not here')\n")
    program = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from simx_client.calls.images import VisionImage, DepthBuffer\n"
        "assert 'numpy' not in sys.modules\n"
        "image = VisionImage.from_bytes(bytes([0, 127, 128, 255, 1, 2]), 2, 1)\n"
        "assert image == [0, 127, -128, -1, 1, 2], image\n"
        "image[0] = 5; assert image.tobytes() == bytes([5, 127, 128, 255, 1, 2])\n"
        "assert DepthBuffer.from_bytes(bytes(8), 2, 1) == [0.0, 0.0]\n"
    )
    root = Path(__file__).parents[2]
    subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=True, cwd=root, timeout=60)
