"""The page's input for an operator: lines of the script, directions, and a real browser that drives an arm."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import msgpack
import numpy as np
import pytest
from browsers import COARSE, FEW_FRAMES, pictures
from processes import read_line, server, wait_until

from simx_client import Client
from simx_client.errors import SimxError
from simx_client.protocol.add_ons.teleoperation import (
    ADD_ON,
    ADD_ON_TYPE,
    GRIPPER,
    MARK,
    STARTED,
    SUCCEEDED,
    Arms,
)
from simx_server.viewer.launching import missing
from simx_server.viewer.page.teleoperation.browser_input import MARKER, Input, marker, parse
from simx_server.viewer.page.teleoperation.frames import axes_of_base, axes_of_view, twist

SOON = 60.0
PAD = "window.pad = null; navigator.getGamepads = () => [window.pad];"
"""In place of a gamepad; its axes and buttons are those of the browser's standard layout."""


def test_a_line_is_a_wish() -> None:
    assert parse("7 1.00 0.00 -0.50 0.00 0.00 0.25 hg3") == Input((1.0, 0.0, -0.5), (0.0, 0.0, 0.25), True, 3)
    still = parse("8 0 0 0 0 0 0 g0")
    assert still is not None
    assert still.is_still
    assert not still.is_held
    assert parse("9 5 0 0 0 0 -5 g0") == Input((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), False, 0)


@pytest.mark.parametrize(
    "line",
    ["", "1 2 3", "1 a 0 0 0 0 0 g0", "1 nan 0 0 0 0 0 g0", "1 0 0 0 0 0 0 g", f"1 0 0 0 0 0 0 g{'0' * 100}"],
)
def test_other_lines_are_no_wish(line: str) -> None:
    assert parse(line) is None


def test_forward_leads_away_from_the_camera_and_along_the_base() -> None:
    wish = Input((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), False, 0)
    # A camera that looks along y and a little down: x is right, y down, z ahead.
    tilt = np.radians(100) / 2
    view = axes_of_view((np.cos(tilt), -np.sin(tilt), 0.0, 0.0))
    seen = twist(wish, view, 0.2, 0.5)
    assert seen == pytest.approx([0.0, 0.2, 0.0, 0.0, 0.0, 0.5])
    left = twist(Input((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), False, 0), view, 0.2, 0.5)
    assert left == pytest.approx([-0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    half = np.sqrt(0.5)
    assert twist(wish, axes_of_base((0.0, 0.0, half, half)), 0.2, 0.5) == pytest.approx(
        [0.0, 0.2, 0, 0, 0, 0.5]
    )


def test_from_straight_above_forward_is_the_upper_side_of_the_view() -> None:
    # A half turn about x: it looks down, and the upper side of its image is y.
    axes = axes_of_view((0.0, 1.0, 0.0, 0.0))
    assert axes[:, 0] == pytest.approx([0.0, 1.0, 0.0])
    assert axes[:, 2] == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.skipif(missing() is not None, reason="the viewer's packages are missing")
def test_two_presses_close_and_open_the_gripper_though_the_page_knows_of_neither() -> None:
    from simx_server.viewer.page.quiet_viser import open_browser_server
    from simx_server.viewer.page.teleoperation.panel import Teleoperation

    sent: list[tuple[str, list[int]]] = []
    client = SimpleNamespace(call=lambda function, _, integers, *__, **___: sent.append((function, integers)))
    hands: Any = SimpleNamespace(do=lambda action: action(client))
    arms = Arms(
        names=["tip"], tip="tip", problem="", gripper="RG2", is_open=True, is_driven=False,
        position=[0.0, 0.0, 1.0], quaternion=[0.0, 0.0, 0.0, 1.0], base=[0.0, 0.0, 0.0, 1.0],
    )  # fmt: skip
    browser = open_browser_server()
    try:
        panel = Teleoperation(browser, hands, "", Teleoperation.add_box(browser.gui))
        for presses in (1, 2):
            panel.show(arms.copy(), is_past=False)  # from before the first press
            line = SimpleNamespace(value=f"{presses} 0 0 0 0 0 0 g{presses}")
            panel._typed(cast("Any", SimpleNamespace(client=SimpleNamespace(client_id=1), target=line)))
    finally:
        browser.stop()
    assert [integers for function, integers in sent if function == GRIPPER] == [[0], [1]]


def test_the_marker_tells_the_script_whether_keys_are_read() -> None:
    assert f"class='{MARKER}' data-on='0'" in marker(is_on=False)
    assert "data-on='1'" in marker(is_on=True)


@pytest.fixture
def view_pictures() -> Any:
    if missing() is not None:
        pytest.skip("needs the extra viewer")
    return pictures()


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.gl
def test_keys_and_a_gamepad_drive_the_arm_until_the_browser_is_gone_and_buttons_mark_an_episode(
    view_pictures: Any,
) -> None:
    with (
        server("pick_place", "--teleop", "UR5", "--view", 0, ports=(0,)) as process,
        Client(f"127.0.0.1:{process.port}") as client,
        view_pictures.chromium() as chromium,
    ):
        url = read_line(process.process, SOON).split()[1]
        page = view_pictures.open_page(chromium, f"{url}?{COARSE}", 900, 600, script=FEW_FRAMES + PAD)

        def arms() -> Arms:
            return cast(Arms, msgpack.unpackb(client.call("arms", ADD_ON, script_type=ADD_ON_TYPE).buffer))

        def holds(condition: Callable[[], bool]) -> Callable[[], bool]:
            """A server on a busy machine refuses calls for a moment."""

            def check() -> bool:
                try:
                    return condition()
                except SimxError:
                    return False

            return check

        def until(condition: Callable[[], bool]) -> bool:
            return wait_until(holds(condition), SOON, lambda: page.wait_for_timeout(20))

        def mark() -> int | None:
            return client.signals.ints.get(MARK, None)

        view_pictures.choose(page, "Drive")
        page.get_by_text("UR5_tip").first.wait_for()
        page.get_by_role("button", name="Start", exact=True).last.click()
        assert until(lambda: client.simulation.state == "running" and mark() == STARTED)
        page.mouse.click(150, 500)
        height = arms()["position"][2]
        page.keyboard.down("KeyE")
        assert until(lambda: arms()["position"][2] < height - 0.02)
        page.keyboard.up("KeyE")
        assert until(lambda: not arms()["is_driven"])
        page.keyboard.press("Space")
        assert until(lambda: not arms()["is_open"])
        height = arms()["position"][2]
        page.evaluate("window.pad = {connected: true, axes: [0, 0, 0, -1], buttons: [{pressed: true}]}")
        assert until(lambda: arms()["is_open"])
        assert until(lambda: arms()["position"][2] > height + 0.02)
        page.evaluate("window.pad = null")
        assert until(lambda: not arms()["is_driven"])
        page.get_by_role("button", name="Success", exact=True).click()
        assert until(lambda: mark() == SUCCEEDED)
        page.keyboard.down("KeyW")
        assert until(lambda: arms()["is_driven"])
        page.close()
        assert wait_until(holds(lambda: not arms()["is_driven"]), SOON)


def test_the_page_drives_an_arm_only_with_the_flag() -> None:
    from simx_server.viewer.page.command import make_parser

    parser = make_parser()
    assert parser.parse_args([]).teleop is None
    assert parser.parse_args(["--teleop"]).teleop == ""
    assert parser.parse_args(["--teleop=UR5"]).teleop == "UR5"
