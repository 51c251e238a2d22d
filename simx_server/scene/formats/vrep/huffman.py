"""The files' compression: one static Huffman code over bytes, its tree written before the codes.

A bit's place is counted from the first bit of the stream, most significant bit of each byte first. A table tells for
each window of bits which whole codes start in it; a code that is longer is walked bit by bit. `native/_huffman.c` does
the same, up to a hundred times faster.
"""

from __future__ import annotations

import numpy as np

from simx_server.scene.formats.annotations import SceneError

from .native.loading import compiled_module

WINDOW = 12
"""Bits looked up at once."""
PLAIN = 4096
"""As few symbols are decoded without a table."""

Tree = list[int]
"""Two numbers for each inner node, its children: another node's index (even) or -1 - symbol; [] for a single leaf."""


def decompress(data: bytes, start: int, length: int) -> memoryview:
    """Return the decoded body.

    Args:
        data: the file.
        start: place of the compressed stream in bytes.
        length: of the body, in bytes.

    Raises:
        SceneError: a damaged tree, a body that ends too early, or bytes left after it.
    """
    tree, symbol, place = _read_tree(data, start)
    if length > len(data) * 8 - place:  # each symbol takes at least one bit
        raise SceneError(
            f"its compressed body has {len(data) - start} bytes and cannot hold the {length} bytes that the "
            "header promises; the file is cut off or damaged"
        )
    decoded = bytearray(length) if tree else bytearray([symbol]) * length
    place = _decode(data, tree, place, decoded) if tree else place + length
    if place > len(data) * 8:
        raise _cut_off(data)
    if len(data) * 8 - place >= 8:
        raise SceneError(
            f"its compressed body ends at byte {(place + 7) // 8}, but the file has {len(data)} bytes; "
            "the file is damaged"
        )
    return memoryview(decoded)


def _read_tree(data: bytes, start: int) -> tuple[Tree, int, int]:
    """Return the tree, the symbol of a tree that is one leaf, and the place of the first code."""
    # 256 leaves of 9 bits and 255 inner nodes of one: the rest is not the tree.
    bits = "".join(f"{byte:08b}" for byte in data[start : start + 320])
    tree: Tree = []
    open_slots: list[int] = []
    place = 0
    while True:
        if place + 9 > len(bits) and (place >= len(bits) or bits[place] == "1"):
            raise SceneError(f"its code tree at byte {start} does not end; the file is cut off or damaged")
        if bits[place] == "0":
            if len(tree) >= 2 * 255:
                raise SceneError(
                    f"its code tree at byte {start} has more than 256 leaves; the file is damaged"
                )
            node = len(tree)
            tree += (0, 0)
            if open_slots:
                tree[open_slots.pop()] = node
            open_slots += (node + 1, node)
            place += 1
            continue
        symbol = int(bits[place + 1 : place + 9], 2)
        place += 9
        if not open_slots:
            return tree, symbol, start * 8 + place
        tree[open_slots.pop()] = -1 - symbol
        if not open_slots:
            return tree, 0, start * 8 + place


def _decode(data: bytes, tree: Tree, place: int, out: bytearray) -> int:
    """Fill `out` with the symbols of the codes from `place` on, and return the place after them."""
    if (compiled := compiled_module()) is not None:
        after: int = compiled.decode(data, np.array(tree, np.int32), place, out)
        if after < 0:
            raise _cut_off(data)
        return after
    done = bytearray()
    if len(out) > PLAIN:
        codes, last = _codes(tree), len(data) * 8 - 24  # the last place with a whole window
        while len(done) <= len(out) - WINDOW and place <= last:
            first = place >> 3
            three = data[first] << 16 | data[first + 1] << 8 | data[first + 2]
            symbols, bits = codes[three >> 24 - WINDOW - (place & 7) & (1 << WINDOW) - 1]
            if bits:
                done += symbols
                place += bits
            else:
                symbol, place = _one_symbol(data, tree, place)
                done.append(symbol)
    while len(done) < len(out):
        symbol, place = _one_symbol(data, tree, place)
        done.append(symbol)
    out[:] = done
    return place


def _codes(tree: Tree) -> list[tuple[bytes, int]]:
    """Return for each window the symbols of the whole codes that start in it, and how many bits these take."""
    found: list[tuple[bytes, int]] = []
    for window in range(1 << WINDOW):
        symbols, bits, node = bytearray(), 0, 0
        for bit in range(WINDOW):
            node = tree[node + (window >> WINDOW - 1 - bit & 1)]
            if node < 0:
                symbols.append(-1 - node)
                bits, node = bit + 1, 0  # after a leaf the next code starts at the root
        found.append((bytes(symbols), bits))
    return found


def _one_symbol(data: bytes, tree: Tree, place: int) -> tuple[int, int]:
    """Return the symbol of the code at a place, and the place after it."""
    node, end = 0, len(data) * 8
    while place < end:
        node = tree[node + (data[place >> 3] >> (7 - (place & 7)) & 1)]
        place += 1
        if node < 0:
            return -1 - node, place
    raise _cut_off(data)


def _cut_off(data: bytes) -> SceneError:
    return SceneError(
        f"its compressed body goes on beyond the last of its {len(data)} bytes; the file is cut off or damaged"
    )
