"""Panels of the page on a viser server that no browser looks at, fed by a whole server in the test's own thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, cast

import msgpack
import pytest
import viser
from real_world import RealWorld

from simx_client import Client
from simx_server.history import History
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import ADD_ON, LOOK, SURVEY, Look, Survey
from simx_server.viewer.page.composition import Panel
from simx_server.viewer.page.link import Hands
from simx_server.viewer.page.quiet_viser import open_browser_server


@pytest.fixture(scope="module")
def browser() -> Iterator[viser.ViserServer]:
    """A viser server that no browser looks at."""
    server = open_browser_server()
    yield server
    server.stop()


class Direct:
    """`Hands` that act at once, and raise what fails."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def do(self, action: Callable[[Client], object]) -> None:
        action(self._client)


class Stage:
    """A world and its feed, the elements of a page, and what a person does to them."""

    def __init__(
        self,
        world: RealWorld,
        client: int,
        browser: viser.ViserServer,
        history: History | None = None,
    ) -> None:
        self.world, self.client, self.gui = world, client, browser.gui
        self.hands = cast(Hands, Direct(Client.of(client)))
        self._feed = Feed(world.loop.service, "test", [19997], history)
        world.parts.scripts.add_ons[ADD_ON] = self._feed
        self._known = -1
        self.panel: Panel | None = None

    def survey(self) -> Survey:
        survey: Survey = self._ask(SURVEY, self._known, -1)
        self._known = survey["tree_version"]
        return survey

    def look(self) -> Look:
        return self._ask(LOOK, -1, -1)

    def show(self) -> None:
        """Bring the panel up to date."""
        assert self.panel is not None
        self.panel.update(self.survey(), self.look())

    def _ask(self, function: str, *known: int) -> Any:
        return msgpack.unpackb(self._feed.call(function, list(known), [], [], b"")[3], strict_map_key=False)

    # --- what stands there -----------------------------------------------------------------------

    def all(self, kind: type) -> list[Any]:
        """The elements of a kind that are to be seen, in order."""
        root = self.gui._container_handle_from_uuid["root"]
        panels = self.gui._panel_handle_from_uuid.values()
        found = [
            each
            for container in (root, *(tab for panel in panels for tab in panel._tab_handles))
            for each in _visible(container)
        ]
        return [each for each in found if isinstance(each, kind)]

    def labelled(self, kind: type, label: str) -> Any:
        """The first whose label contains a text."""
        found = self.all(kind)
        return next(each for each in found if label in each.label)

    def text(self) -> str:
        """All HTML."""
        return "\n".join(each.content for each in self.all(viser.GuiHtmlHandle))

    # --- what a person does ----------------------------------------------------------------------

    def click(self, label: str) -> None:
        _tell(self.labelled(viser.GuiButtonHandle, label))

    def set(self, element: Any, value: Any) -> None:
        element._impl.value = value  # as a browser's message does, before the callbacks are called
        _tell(element)


def _visible(container: Any) -> list[Any]:
    found = []
    for each in sorted(container._children.values(), key=lambda each: each._impl.props.order):
        if getattr(each, "visible", True):
            found += [each, *_visible(each)] if hasattr(each, "_children") else [each]
    return found


def _tell(element: Any) -> None:
    somebody = cast(viser.ClientHandle, object())
    for callback in element._impl.update_cb:
        callback(viser.GuiEvent(somebody, 1, element))
