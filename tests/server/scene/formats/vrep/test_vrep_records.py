"""The list of all records."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from vrep_packing import chunk

from simx_server.scene.formats.vrep.chunks import DEEPEST, MOST_LISTS, Body, Chunks, has_twin, sections, twin
from simx_server.scene.formats.vrep.decoding import clouds, common, shapes
from simx_server.scene.formats.vrep.reading import FIRST, MOST_OBJECTS, OBJECTS, REST
from simx_server.scene.formats.vrep.records import RECORDS


@pytest.mark.parametrize("name", RECORDS)
def test_no_two_records_of_a_list_have_the_same_twin(name: str) -> None:
    twins = [twin(tag) for tag, form in RECORDS[name].items() if has_twin(form)]
    assert len(set(twins)) == len(twins)
    assert not set(twins) & set(RECORDS[name])


@pytest.mark.parametrize("name", RECORDS)
def test_lists_within_lists_are_in_the_list(name: str) -> None:
    inner = [form.removeprefix("list ") for form in RECORDS[name].values() if form.startswith("list ")]
    assert set(inner) <= set(RECORDS)


def test_every_list_is_reached_from_the_top() -> None:
    reached = {"object", "VIN", "surface", *OBJECTS, *FIRST, *(name for name, _ in REST.values())} - {"DMA"}
    waiting = [*reached]
    while waiting:
        forms = RECORDS[waiting.pop()].values()
        new = {form.removeprefix("list ") for form in forms if form.startswith("list ")} - reached
        reached |= new
        waiting += new
    assert reached == set(RECORDS)


def joint(data: bytes) -> Chunks:
    (chunks,) = sections(Body(memoryview(data), "a test"), ["JNT"], 0, len(data))
    return chunks


def test_the_twin_is_preferred_wherever_it_stands() -> None:
    short, long = chunk("Prt", struct.pack("<f", 0.1)), chunk("_rt", struct.pack("<d", 0.1))
    for data in (short + long, long + short, long):
        assert joint(data).reals("Prt") == (0.1,)
    assert joint(short).reals("Prt") == pytest.approx((0.1,))
    assert joint(short).reals("Prt") != (0.1,)


def test_whole_numbers_of_a_twin_stay_short() -> None:
    chunks = joint(chunk("_dt", struct.pack("<i2d", 7, 0.1, -0.2)))
    assert (chunks.ints("Jdt"), chunks.reals("Jdt")) == ((7,), (0.1, -0.2))


def test_parameters_of_engines_follow_the_same_rule() -> None:
    short = chunk("BtN", struct.pack("<2i2f1i", 2, 1, 0.5, 0.25, 9))
    long = chunk("_tN", struct.pack("<2i2d1i", 2, 1, 0.1, 0.2, 8))
    assert joint(short).array("BtN") == ([0.5, 0.25], [9])
    assert joint(short + long).array("BtN") == ([0.1, 0.2], [8])
    assert joint(b"").array("BtN") is None


def test_a_longer_payload_than_known_is_read_as_far_as_it_is_known() -> None:
    assert joint(chunk("Pmr", struct.pack("<3f", 1, 2, 3))).reals("Pmr") == (1, 2)


def test_records_after_a_mark_belong_to_the_next_section() -> None:
    data = chunk("Var", b"\1") + b"EOO" + chunk("Var", b"\2") + b"EOO" + chunk("Var", b"\3")
    wrapper, leaf = sections(Body(memoryview(data), "a test"), ["group", "leaf"], 0, len(data))
    assert (wrapper.ints("Var"), leaf.ints("Var")) == ((1,), (2,))


PAGE = (Path(__file__).parents[5] / "docs" / "internals" / "vrep-files.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("tag", sorted({*OBJECTS, *FIRST, *REST} - {"MKR", "CSO"}))
def test_the_page_names_each_record_of_the_top_level(tag: str) -> None:
    assert f"`{tag}`" in PAGE


def test_the_page_tells_the_limits() -> None:
    limits = {
        "objects": MOST_OBJECTS,
        "leaves of shapes": shapes.MOST_LEAVES,
        "lists": MOST_LISTS,
        "lists within each other": DEEPEST,
        "cells within each other": clouds.DEEPEST,
        "custom data blocks of an object": common.MOST_BLOCKS,
        "parameters of an object or a script": common.MOST_PARAMETERS,
    }
    for what, number in limits.items():
        assert f"| {what} | {number:,} |" in PAGE
