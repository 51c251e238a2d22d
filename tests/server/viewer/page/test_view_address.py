"""The address of a browser: what it names, and what it leaves out."""

from __future__ import annotations

import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

from simx_server.viewer.page.tools.address import Address, View, parse

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    "address",
    [
        Address(),
        Address(View((1.2, -1.4, 1.0), (0.0, 0.0, 0.3))),
        Address(View((1.0, 2.0, 3.0), (0.5, 0.0, 0.0), (0.0, 1.0, 0.0), 60.0), "UR5_joint1#0", 120),
        Address(None, "a & b = c?", 0),
    ],
)
def test_an_address_is_read_as_it_was_written(address: Address) -> None:
    assert parse(address.text()) == address


def test_an_address_is_short_and_leaves_out_what_is_usual() -> None:
    assert (
        Address(View((1.2, -1.4, 1.0), (0.0, 0.0, 0.3)), "UR5").text()
        == "at=1.2,-1.4,1&to=0,0,0.3&object=UR5"
    )


@pytest.mark.parametrize(
    "text",
    [
        "at=1,2,3",
        "at=1,2,3&to=1,2,3",
        "at=1,2,nan&to=0,0,0",
        "at=1,2,inf&to=0,0,0",
        "at=1,2,1e30&to=0,0,0",
        "at=1,2&to=0,0,0",
        "at=a,b,c&to=0,0,0",
        "step=-1&step=x",
        "&".join(f"a{number}=1" for number in range(100)),
        "token=abc",
        "at=%",
    ],
)
def test_parts_of_an_address_that_cannot_be_used_are_left_out(text: str) -> None:
    assert parse(text) == Address()
    assert parse(f"{text[:80]}&object=box").object == "box"


def test_of_angles_and_directions_only_possible_ones_are_used() -> None:
    view = parse("at=1,0,0&to=0,0,0&fov=170&up=0,0,0").view
    assert view == View((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
