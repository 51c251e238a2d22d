"""Bits of integers: Lua had no operators for them when V-REP's scripts were written."""

from __future__ import annotations

from simx_server.sim_api.base import ApiPart


class BitFunctions(ApiPart, effect="reads"):
    """Functions for bits of 32-bit integers, or of their low 16 bits."""

    def boolAnd32(self, first: int, second: int) -> int:
        return first & second

    def boolOr32(self, first: int, second: int) -> int:
        return first | second

    def boolXor32(self, first: int, second: int) -> int:
        return first ^ second

    def boolAnd16(self, first: int, second: int) -> int:
        return first & second & 0xFFFF

    def boolOr16(self, first: int, second: int) -> int:
        return (first | second) & 0xFFFF

    def boolXor16(self, first: int, second: int) -> int:
        return (first ^ second) & 0xFFFF

    boolAnd = boolAnd32
    boolOr = boolOr32
    boolXor = boolXor32
