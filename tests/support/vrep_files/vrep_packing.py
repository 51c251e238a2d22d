"""How V-REP's files pack bytes: the code of the whole body, records, meshes, script texts. For `vrep_writer.py`."""

from __future__ import annotations

import heapq
import re
import struct
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

Tree = int | tuple["Tree", "Tree"]
"""A symbol, or the trees of bit 0 and bit 1."""


def header(
    body: bytes,
    *,
    serialization: int,
    program: tuple[int, int, int],
    compression: int,
    kind: int,
    revision: int = 0,
) -> bytes:
    """Return the 1021 bytes before the body."""
    major, minor, patch = program
    fields = struct.pack(
        "<4siiBIiHiBB",
        b"VREP",
        serialization,
        16,
        compression,
        len(body),
        0,
        major * 10000 + minor * 100 + patch,
        0,
        revision,
        kind,
    )
    return fields.ljust(1021, b"\0")


def huffman_tree(data: bytes) -> Tree:
    """Return the tree that codes these bytes shortest."""
    heap: list[tuple[int, int, Tree]] = [
        (count, symbol, symbol) for symbol, count in sorted(Counter(data or b"\0").items())
    ]
    heapq.heapify(heap)
    number = 256
    while len(heap) > 1:
        few, _, first = heapq.heappop(heap)
        more, _, second = heapq.heappop(heap)
        heapq.heappush(heap, (few + more, number, (first, second)))
        number += 1
    return heap[0][2]


def codes_of(tree: Tree) -> dict[int, str]:
    """Return each symbol's code as text of 0 and 1. A tree of one leaf has a code of one bit."""
    if isinstance(tree, int):
        return {tree: "0"}
    found: dict[int, str] = {}
    waiting: list[tuple[Tree, str]] = [(tree, "")]
    while waiting:
        node, code = waiting.pop()
        if isinstance(node, int):
            found[node] = code
        else:
            waiting += [(node[1], code + "1"), (node[0], code + "0")]
    return found


def tree_bits(tree: Tree) -> str:
    """Return the tree as it stands before the codes."""
    parts: list[str] = []
    waiting: list[Tree] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, int):
            parts.append(f"1{node:08b}")
        else:
            parts.append("0")
            waiting += [node[1], node[0]]
    return "".join(parts)


def compress(data: bytes, tree: Tree | None = None) -> bytes:
    """Return the body compressed with a tree, by default the best one."""
    tree = huffman_tree(data) if tree is None else tree
    codes, start = codes_of(tree), tree_bits(tree)
    if max(map(len, codes.values())) > 60:  # longer than a word of NumPy
        bits = start + "".join(codes[byte] for byte in data)
        return int(bits, 2).to_bytes(0, "big") if not bits else _bytes_of(bits)
    lengths, words = np.zeros(256, np.int64), np.zeros(256, np.int64)
    for symbol, code in codes.items():
        lengths[symbol], words[symbol] = len(code), int(code, 2)
    octets = np.frombuffer(data, np.uint8)
    parts = [np.frombuffer(start.encode(), np.uint8) - ord("0")]
    for first in range(0, octets.size, 1 << 20):
        parts.append(_bits_of(octets[first : first + (1 << 20)], lengths, words))
    return np.packbits(np.concatenate(parts)).tobytes()


def _bits_of(octets: np.ndarray, lengths: np.ndarray, words: np.ndarray) -> np.ndarray:
    sizes = lengths[octets]
    ends = np.cumsum(sizes)
    bits = np.zeros(int(ends[-1]) if ends.size else 0, np.uint8)
    for place in range(int(lengths.max())):
        which = sizes > place
        shift = sizes[which] - 1 - place
        bits[(ends - sizes)[which] + place] = words[octets[which]] >> shift & 1
    return bits


def _bytes_of(bits: str) -> bytes:
    padded = bits + "0" * (-len(bits) % 8)
    return int(padded, 2).to_bytes(len(padded) // 8, "big")


def text(value: str) -> bytes:
    """Return a text with its length."""
    data = value.encode()
    return struct.pack("<i", len(data)) + data


def chunk(tag: str, payload: bytes = b"") -> bytes:
    """Return a record."""
    return tag.encode() + struct.pack("<I", len(payload)) + payload


def listed(tag: str, *records: bytes) -> bytes:
    """Return a record that is a list."""
    return chunk(tag, b"".join(records) + b"EOO")


def numbers(tag: str, form: str, values: Sequence[Any], serialization: int) -> bytes:
    """Return a record of numbers: `r` in the form is float32 under this tag, float64 under the twin's."""
    letters = "".join(letter * int(count or 1) for count, letter in re.findall(r"(\d*)(\w)", form))
    if len(letters) != len(values):
        raise ValueError(f"{tag} wants {len(letters)} numbers, not {len(values)}")
    written = b""
    if "r" not in letters or serialization < 25:
        written += chunk(tag, struct.pack("<" + letters.replace("r", "f"), *values))
    if "r" in letters and serialization >= 24:
        written += chunk("_" + tag[1:], struct.pack("<" + letters.replace("r", "d"), *values))
    return written


def array(tag: str, reals: Sequence[float], ints: Sequence[int], serialization: int) -> bytes:
    """Return the parameters of a physics engine."""
    form = f"2i{len(reals)}r" + (f"{len(ints)}i" if ints else "")
    return numbers(tag, form, (len(reals), len(ints), *reals, *ints), serialization)


def packed_indices(indices: Sequence[int]) -> bytes:
    """Return indices as differences of one to four bytes (`In2`)."""
    out, last = bytearray(struct.pack("<i", len(indices))), 0
    for index in indices:
        difference, last = index - last, index
        for extra, offset in enumerate((31, 8191, 2097151, 536870911)):
            value = difference + offset
            if 0 <= value < 1 << (6 + 8 * extra):
                out.append(value & 63 | extra << 6)
                out += (value >> 6).to_bytes(extra, "little")
                break
    return bytes(out)


def packed_normals(normals: np.ndarray) -> bytes:
    """Return normals as 16 bits each (`No2`)."""
    levels = np.clip(np.round(np.asarray(normals).reshape(-1, 3) * 15), -15, 15).astype(np.int64) + 15
    return (levels[:, 0] | levels[:, 1] << 5 | levels[:, 2] << 10).astype("<u2").tobytes()


def masked(script: str) -> bytes:
    """Return a script's text as files have it, see `masked_bytes`."""
    return masked_bytes(script.encode() + b"\0")


def masked_bytes(data: bytes) -> bytes:
    """Return bytes shifted by their places and by both end bytes."""
    size = len(data)
    if size < 3:
        return data
    first, last = (int.from_bytes(data[at : at + 1], "little", signed=True) for at in (0, size - 1))
    start, end = int(first / 2), 3 * last
    out = bytearray(data)
    for place in range(1, size - 1):
        shift = (place + start + end) * (place & 1)
        shift -= (3 * place + start) * (place >> 1 & 1)
        shift += ((place >> 1) + end) * (place >> 2 & 1)
        out[place] = (data[place] - shift) & 255
    return bytes(out)
