"""Hostile files in V-REP's format: refused with a sentence, or read; never an unforeseen error."""

from __future__ import annotations

import random

import pytest
from fuzz.vrep import Reader, bases
from seeds import many

from simx_server.scene.formats.vrep.reading import read_file

pytestmark = pytest.mark.slow

CASES = many(120)


def test_no_file_is_more_than_an_error() -> None:
    source, reader = random.Random(1), Reader()
    for _ in range(CASES):
        data = source.randbytes(source.choice((8, 12, 20, 40)))
        try:
            reader.one(data)
        except Exception as error:
            raise AssertionError(f"python tests/fuzz/run.py vrep -r {data.hex()}") from error
    assert CASES / 8 < reader.read < CASES * 7 / 8, "else next to nothing is tried"


def test_the_files_are_good_before_they_are_altered() -> None:
    for data in bases():
        assert len(read_file(data, "good.ttt").objects) > 1
