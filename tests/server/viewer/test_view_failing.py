"""A part of the page that fails is marked, and told once in the log; all others go on."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

from browser_panels import Stage
from real_world import Open

from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page import composition
from simx_server.viewer.page.composition import Page
from simx_server.viewer.page.panels.objects import Objects
from simx_server.viewer.page.quiet_viser import open_browser_server
from simx_server.viewer.page.view import world

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <worldbody>
    <body name="arm"><joint name="hinge"/><geom size="0.1"/></body>
    <body name="post"><geom size="0.2"/></body>
  </worldbody>
</mujoco>
"""
NOWHERE = "127.0.0.1:9"


class Told:
    """In the place of an `Eye`: the feed of a world in this thread. Ends the page after some surveys."""

    def __init__(self, stage: Stage, page: Page) -> None:
        self._stage, self._page = stage, page
        self.surveys_left = 1

    def look(self) -> Look:
        return self._stage.look()

    def survey(self) -> Survey:
        self.surveys_left -= 1
        if not self.surveys_left:
            self._page.end()
        return self._stage.survey()

    def forget_look(self) -> None:
        """Each look holds everything."""

    def forget_survey(self) -> None:
        self._stage._known = -1

    def close(self) -> None:
        """Nothing to end."""


class Looked:
    """A page of a scene; `go_on` has it bring itself up to date."""

    def __init__(self, stage: Stage, page: Page) -> None:
        self.stage, self.page = stage, page
        self.told: Any = Told(stage, page)
        page._eye = self.told

    def go_on(self, surveys: int = 1) -> None:
        self.told.surveys_left = surveys
        self.page._ending.clear()
        self.page.run()

    def text(self) -> str:
        """What stands in all tabs."""
        containers = self.stage.gui._container_handle_from_uuid.values()
        elements = [each for container in containers for each in container._children.values()]
        shown = [each for each in elements if getattr(each, "visible", True)]
        return "\n".join(str(getattr(each, "content", getattr(each, "label", ""))) for each in shown)


@pytest.fixture
def looked(world: Open, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Looked]:
    for name in ("LOOKS", "SURVEYS", "UNSEEN", "AGAIN"):
        monkeypatch.setattr(composition, name, 0.0)
    (tmp_path / "scene.xml").write_text(SCENE)
    browser = open_browser_server()
    page = Page(browser, NOWHERE)
    yield Looked(Stage(*world(str(tmp_path / "scene.xml")), browser), page)
    page.close()
    browser.stop()


def failing(problem: str) -> Callable[..., None]:
    def fail(*_: object) -> None:
        raise RuntimeError(problem)

    return fail


def test_a_panel_that_fails_is_marked_and_logged_once_and_the_others_go_on(
    looked: Looked, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    with monkeypatch.context() as broken:
        broken.setattr(Objects, "update", failing("<b>broken"))
        looked.go_on(surveys=3)
    shown = looked.text()
    assert "RuntimeError(&#x27;&lt;b&gt;broken&#x27;)" in shown
    assert "is at 0.0°" in shown, "the tab after it has news"
    errors = [each for each in caplog.records if each.levelno == logging.ERROR]
    assert len(errors) == 1
    assert "the tab of objects" in errors[0].message
    assert errors[0].exc_info, "with where it failed"
    looked.go_on()
    assert "broken" not in looked.text()
    assert "hinge  ·" in looked.text(), "it has the tree that it missed"


def test_the_panels_go_on_without_the_3d_view(
    looked: Looked, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    with monkeypatch.context() as broken:
        broken.setattr(world.World, "update", failing("no view"))
        looked.go_on(surveys=2)
    assert "no view" in looked.text()
    assert "is at 0.0°" in looked.text()
    assert "the 3-D view" in caplog.text
    looked.go_on()
    assert "no view" not in looked.text()
    assert looked.page._world._bodies


def test_a_body_that_cannot_be_drawn_is_left_out(
    looked: Looked, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    drawn = world.meshes_of

    def meshes_of(model: Any, body: int) -> Any:
        if body == model.body("arm").id:
            raise ValueError("no such mesh")
        return drawn(model, body)

    monkeypatch.setattr(world, "meshes_of", meshes_of)
    looked.go_on(surveys=2)
    assert len(looked.page._world._bodies) == 1
    assert "no such mesh" not in looked.text()
    assert "body 'arm' cannot be drawn" in caplog.text
