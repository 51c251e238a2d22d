"""The files' compression against a plain decoder that follows the tree bit by bit."""

from __future__ import annotations

import random
import sys

import numpy as np
import pytest
from processes import finished
from vrep_packing import Tree, codes_of, compress, huffman_tree, tree_bits

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.huffman import decompress
from simx_server.scene.formats.vrep.native import loading


@pytest.fixture(autouse=True, params=["compiled", "python"])
def form(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test is made with both forms."""
    if request.param == "python":
        monkeypatch.setenv(loading.VARIABLE, "python")
    elif loading.form().module is None:
        pytest.skip(loading.form().reason)


def plain(data: bytes, length: int) -> bytes:
    """Decode as the format is described, one bit at a time."""
    bits = "".join(f"{byte:08b}" for byte in data)
    place = 0

    def tree() -> Tree:
        nonlocal place
        place += 1
        if bits[place - 1] == "1":
            place += 8
            return int(bits[place - 8 : place], 2)
        first = tree()
        return first, tree()

    root, out = tree(), bytearray()
    while len(out) < length:
        node = root
        if isinstance(node, int):
            place += 1
        while not isinstance(node, int):
            node = node[int(bits[place])]
            place += 1
        out.append(node)
    assert len(bits) - place < 8
    return bytes(out)


def chain(depth: int) -> Tree:
    """A tree of `depth` + 1 leaves whose codes have 1, 2, 3, ... bits."""
    tree: Tree = depth
    for symbol in reversed(range(depth)):
        tree = (symbol, tree)
    return tree


def mirrored(tree: Tree) -> Tree:
    return tree if isinstance(tree, int) else (mirrored(tree[1]), mirrored(tree[0]))


def some_bytes(seed: int, size: int, symbols: int, share: float) -> bytes:
    """Bytes of which a share is one symbol and the rest any of `symbols`."""
    source = random.Random(seed)
    return bytes(0 if source.random() < share else source.randrange(symbols) for _ in range(size))


TEXTS = {
    "nothing": b"",
    "one byte": b"a",
    "one symbol": b"\0" * 7_001,
    "two symbols": some_bytes(1, 6_000, 2, 0.5),
    "mostly zeros": some_bytes(2, 9_000, 200, 0.95),
    "any bytes": some_bytes(3, 5_000, 256, 0.0),
    "seven bits each": some_bytes(4, 5_000, 128, 0.0),
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS.keys())
def test_bytes_come_out_as_they_went_in(text: bytes) -> None:
    packed = compress(text)
    assert decompress(b"header" + packed, 6, len(text)) == text == plain(packed, len(text))


@pytest.mark.parametrize("depth", [1, 11, 12, 13, 24, 100])
@pytest.mark.parametrize("is_mirrored", [False, True])
def test_codes_longer_than_the_window_are_decoded(depth: int, is_mirrored: bool) -> None:
    source = random.Random(depth)
    # Rare as in files that were compressed well, then all codes alike, then long ones only.
    rare = [min(int(source.expovariate(0.7)), depth) for _ in range(6_000)]
    text = bytes(rare + [source.randrange(depth + 1) for _ in range(2_000)] + [depth] * 1_000)
    tree = mirrored(chain(depth)) if is_mirrored else chain(depth)
    packed = compress(text, tree)
    assert max(map(len, codes_of(tree).values())) == depth
    assert decompress(packed, 0, len(text)) == text == plain(packed, len(text))


def test_the_deepest_tree_is_decoded() -> None:
    text = bytes(range(256)) * 40
    assert decompress(compress(text, chain(255)), 0, len(text)) == text


@pytest.mark.parametrize("size", [1, 4095, 4096, 4097, 4098, 20_000])
def test_sizes_around_that_of_small_bodies_are_decoded(size: int) -> None:
    text = some_bytes(size, size, 60, 0.7)
    assert decompress(compress(text), 0, size) == text


@pytest.mark.parametrize("size", [100, 10_000])
def test_a_body_that_is_cut_off_is_an_error(size: int) -> None:
    text = some_bytes(5, size, 90, 0.5)
    packed = compress(text)
    for end in (*range(0, len(packed), max(1, len(packed) // 12)), len(packed) - 1):
        with pytest.raises(SceneError, match="cut off"):
            decompress(packed[:end], 0, size)


def test_bytes_after_the_body_are_an_error() -> None:
    text = some_bytes(6, 20_000, 90, 0.5)
    with pytest.raises(SceneError, match="bytes"):
        decompress(compress(text) + b"\0", 0, len(text))


def test_a_length_that_cannot_be_is_refused_before_memory_is_taken() -> None:
    packed = compress(b"abcabc")
    with pytest.raises(SceneError, match="cannot hold the 4294967295 bytes"):
        decompress(packed, 0, 2**32 - 1)


def test_the_compiled_form_refuses_what_is_no_tree() -> None:
    """`decompress` passes none; the C code must not read outside of it if that ever changes."""
    if (compiled := loading.compiled_module()) is None:
        pytest.skip("in Python there is nothing to refuse")
    out = bytearray(100)
    for tree, place in (([], 0), ([0], 0), ([0, 2], 0), ([1, -1], 0), ([-1, -258], 0), ([-1, -2], -1)):
        with pytest.raises(ValueError, match="no tree"):
            compiled.decode(bytes(100), np.array(tree, np.int32), place, out)
    assert compiled.decode(b"", np.array([-1, -2], np.int32), 0, out) == -1
    assert compiled.decode(bytes(3), np.array([-1, -2], np.int32), 1 << 40, out) == -1


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not limit open files")
def test_a_trial_that_can_open_no_file_uses_the_same_form() -> None:
    """The module is loaded before; without it a client's file would be decoded in Python."""
    program = (
        "import resource; from simx_server.scene.formats.vrep.opening import prepare_for_trial; prepare_for_trial(); "
        "resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0)); "
        "from simx_server.scene.formats.vrep.native.loading import form; print(form().reason)"
    )
    done = finished("-c", program)
    assert (done.stdout.strip(), done.stderr) == (loading.form().reason, "")


def test_a_tree_of_too_many_leaves_is_an_error() -> None:
    tree = tree_bits(huffman_tree(bytes(range(256)))).replace("1", "0", 1)
    data = int(tree.ljust(4000, "0"), 2).to_bytes(500, "big")
    with pytest.raises(SceneError, match="tree"):
        decompress(data, 0, 10)
