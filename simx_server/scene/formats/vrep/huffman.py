"""The files' compression: one static Huffman code over bytes, its tree written before the codes.

A bit's place is counted from the first bit of the stream, most significant bit of each byte first. The body is
decoded in blocks. In a block, a table of all 16-bit windows tells for *every* bit how many bits the whole codes
take that start there; following this a few times for all bits at once gives long strides, a plain loop walks the
strides, and their codes are then looked up side by side. So the plain loop runs once for some hundred bits.
A code that is longer than the window is walked bit by bit; compressors give those to bytes that are very rare.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.annotations import SceneError

WINDOW = 16
"""Bits looked up at once."""
AT_ONCE = {np.dtype("<u8"): 8, np.dtype("<u4"): 4}
"""Most symbols that one look-up gives, by the type of number that holds them; fewer where codes are long."""
LONG = 4.0
"""Mean bits of a code from which a look-up seldom gives more than four symbols."""
DOUBLINGS = 3
"""A stride is 2**DOUBLINGS look-ups."""
BLOCK = 1 << 17
"""Bits decoded at a time; its arrays stay in the processor's cache."""
NO_WINDOW = 1 << WINDOW
"""Stands for a window at places that belong to the next block: no code starts there."""
PLAIN = 4096
"""As few symbols are decoded one by one."""

Tree = list[int]
"""Two numbers for each inner node, its children: another node's index (even) or -1 - symbol; [] for a single leaf."""


@dataclass(frozen=True)
class _Tables:
    """Codes that start in each window, and in NO_WINDOW: whole ones only, as many as a look-up gives."""

    symbols: NDArray[np.uint64] | NDArray[np.uint32]
    """The symbols, one in each byte, the first one in the first byte."""
    counts: NDArray[np.uint8]
    bits: NDArray[np.uint8]
    """How many bits the codes take; 0 where the first code is longer than the window."""
    nodes: NDArray[np.intp]
    """The inner node at which the window ends, where the first code is longer."""
    kept: NDArray[np.bool_]
    """(counts, symbols of a look-up): which of the bytes are symbols."""


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
    if tree:
        decoded = np.empty(length, np.uint8)
        place = _decode(data, tree, place, decoded)
    else:
        decoded, place = np.full(length, symbol, np.uint8), place + length
    if place > len(data) * 8:
        raise _cut_off(data)
    if len(data) * 8 - place >= 8:
        raise SceneError(
            f"its compressed body ends at byte {(place + 7) // 8}, but the file has {len(data)} bytes; "
            "the file is damaged"
        )
    return memoryview(decoded)  # type: ignore[arg-type] - an array has a buffer


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


def _mean_bits(tree: Tree) -> float:
    """Return the mean length of the codes, of symbols as frequent as these lengths suit best."""
    mean, waiting = 0.0, [(0, 1)]
    while waiting:
        node, depth = waiting.pop()
        for child in tree[node : node + 2]:
            if child >= 0:
                waiting.append((child, depth + 1))
            else:
                mean += depth * 0.5**depth
    return mean


def _tables(tree: Tree) -> _Tables:
    """Walk the tree with all windows at once."""
    kind = np.dtype("<u4" if _mean_bits(tree) > LONG else "<u8")
    most = AT_ONCE[kind]
    windows = np.arange(NO_WINDOW, dtype=np.intp)
    children = np.array(tree, np.intp)
    symbols = np.zeros((NO_WINDOW + 1, most), np.uint8)
    counts, bits = np.zeros(NO_WINDOW + 1, np.uint8), np.zeros(NO_WINDOW + 1, np.uint8)
    node = np.zeros_like(windows)
    for bit in range(WINDOW):
        node = children[node + (windows >> (WINDOW - 1 - bit) & 1)]
        at_leaf = np.flatnonzero((node < 0) & (counts[:-1] < most))
        symbols[at_leaf, counts[at_leaf]] = -1 - node[at_leaf]
        counts[at_leaf] += 1
        bits[at_leaf] = bit + 1
        node = np.maximum(node, 0)  # after a leaf the next code starts at the root
    kept = np.arange(most) < np.arange(most + 1)[:, None]
    return _Tables(symbols.view(kind).reshape(-1), counts, bits, node, kept)


def _decode(data: bytes, tree: Tree, place: int, out: NDArray[np.uint8]) -> int:
    """Fill `out` with the symbols of the codes from `place` on, and return the place after them."""
    tables = _tables(tree) if out.size > PLAIN else None
    done, end = 0, len(data) * 8
    while tables is not None:
        # A block of n bits gives at most n symbols, and those of a last look-up that starts in it.
        bits = min(BLOCK, out.size - done - WINDOW, end - place)
        if bits < PLAIN:
            break
        found, place = _decode_block(data, tree, tables, place, bits)
        out[done : done + found.size] = found
        done += found.size
    rest = bytearray()
    while done + len(rest) < out.size:
        symbol, place = _one_symbol(data, tree, place, 0)
        rest.append(symbol)
    out[done:] = np.frombuffer(rest, np.uint8)
    return place


def _one_symbol(data: bytes, tree: Tree, place: int, node: int) -> tuple[int, int]:
    """Return the symbol of the code that goes on from `node` at `place`, and the place after it."""
    end = len(data) * 8
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


def _decode_block(
    data: bytes, tree: Tree, tables: _Tables, place: int, bits: int
) -> tuple[NDArray[np.uint8], int]:
    """Return the symbols of all codes that start within this number of bits from `place`, and the place after them.

    Places in the block are counted from the first bit of the byte in which it starts.
    """
    first, end = place & ~7, (place & 7) + bits
    triples = _triples(data, first >> 3, (end >> 3) + 4)
    next_place = _next_places(tables, triples, end)
    stride = next_place
    for _ in range(DOUBLINGS):
        stride = stride.take(stride, mode="clip")  # faster than with the mode that raises; nothing is cut
    strides = memoryview(stride)  # type: ignore[arg-type] - read faster than the array itself
    lanes: list[int] = []
    long_symbols: dict[int, int] = {}
    at = place & 7
    while at < end:
        lanes.append(at)
        beyond = strides[at]
        if beyond == at:
            node = tables.nodes.item(_windows(triples, np.array([at])).item())
            long_symbols[len(lanes) - 1], beyond = _one_symbol(data, tree, first + at + WINDOW, node)
            beyond -= first
        at = beyond
    found = _look_up(tables, triples, next_place, end, np.array(lanes, np.intp), long_symbols)
    return found, first + at


def _triples(data: bytes, start: int, size: int) -> NDArray[np.intp]:
    """Return three bytes as one number, from each byte of a piece on; zeros beyond the end of the data."""
    octets = np.frombuffer(data[start : start + size + 2].ljust(size + 2, b"\0"), np.uint8).astype(np.intp)
    return octets[:-2] << 16 | octets[1:-1] << 8 | octets[2:]


def _next_places(tables: _Tables, triples: NDArray[np.intp], end: int) -> NDArray[np.intp]:
    """Return for each bit where the codes of a look-up there end. Places from `end` on lead to themselves."""
    next_place = np.empty((triples.size, 8), np.intp)
    place = np.arange(0, triples.size * 8, 8)
    for bit in range(8):
        windows = triples >> 8 - bit
        windows &= NO_WINDOW - 1
        np.add(place, tables.bits.take(windows, mode="clip"), out=next_place[:, bit])
        place += 1
    flat = next_place.reshape(-1)
    flat[end:] = np.arange(end, flat.size)
    return flat


def _windows(triples: NDArray[np.intp], places: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the windows at some places."""
    return triples.take(places >> 3, mode="clip") >> (8 - (places & 7)) & NO_WINDOW - 1


def _look_up(
    tables: _Tables,
    triples: NDArray[np.intp],
    next_place: NDArray[np.intp],
    end: int,
    lanes: NDArray[np.intp],
    long_symbols: dict[int, int],
) -> NDArray[np.uint8]:
    """Return the symbols of the strides that start at `lanes`, each followed by that of its long code, if any."""
    steps = 1 << DOUBLINGS
    places = np.empty((lanes.size, steps + 1), np.intp)
    for step in range(steps):
        places[:, step] = lanes
        lanes = next_place.take(lanes, mode="clip")
    places[:, steps] = end
    flat = places.reshape(-1)
    looked_up = np.where(flat < end, _windows(triples, flat), NO_WINDOW)
    symbols, counts = tables.symbols.take(looked_up, mode="clip"), tables.counts.take(looked_up, mode="clip")
    if long_symbols:
        which = np.fromiter(long_symbols, np.intp) * (steps + 1) + steps
        symbols[which] = np.fromiter(long_symbols.values(), np.uint64)
        counts[which] = 1
    kept = tables.kept.take(counts, axis=0, mode="clip")
    return symbols.view(np.uint8).reshape(kept.shape)[kept]
