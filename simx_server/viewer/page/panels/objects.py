"""The objects of the scene as a tree, with the names and handles that scripts use."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence

import viser

from simx_server.viewer.messages import Look, SceneItem, Survey
from simx_server.viewer.page.link import Hands, make

from .elements import put

ROWS = 80
"""Buttons; with more objects, the user searches, or opens models one at a time."""

_OPEN_DEPTH = 3
"""Objects deeper than this are folded at first."""

_DETAILS = 5
"""Selected objects that are described."""

_INDENT = "\u2007" * 2  # a space as wide as a digit, which browsers keep

_STYLE = """<i class="simx-tree"></i><style>
div:has(> .simx-tree) ~ div { padding-bottom: 0 !important; }
div:has(> .simx-tree) ~ div .mantine-Button-root { height: 1.75em !important; padding: 0 0.5em; }
div:has(> .simx-tree) ~ div .mantine-Button-inner { justify-content: flex-start; }
div:has(> .simx-tree) ~ div .mantine-Button-section { position: absolute; right: 0; }
div:has(> .simx-tree) ~ div .mantine-Button-root:not(:has(svg)) {
  background: transparent; color: inherit; font-weight: 400; }
div:has(> .simx-tree) ~ div .mantine-Button-root:not(:has(svg)):hover { background: rgba(128,128,128,0.15); }
</style>"""
"""Makes the buttons that follow look like rows; the one with an icon is the selected one."""

_HELP = "Click to select, once more to open or fold ▸. Type a name, path, type or handle to search."


class Objects:
    """The tree. Its selection is the selection of the remote API, which any client may change."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._hands = hands
        self._items: dict[int, SceneItem] = {}
        self._parents: set[int] = set()
        self._dull: set[int] = set()
        """Objects folded at first since only cameras and lights are below them."""

        self._version = -1
        self._selection: list[int] = []
        self._is_open: dict[tuple[int, str], bool] = {}
        """By handle and name, where a user has opened or folded it."""

        self._shown: Sequence[SceneItem] = ()
        self._drawn: object = None
        """The data from which the rows were made."""

        self._search = gui.add_text("Search", "", hint=_HELP)
        self._details = gui.add_html("", visible=False)
        gui.add_html(f"<div class='simx-long' style='{_SMALL};opacity:0.8'>{_HELP}</div>")
        with gui.add_folder(None):
            gui.add_html(_STYLE)
            self._rows = [gui.add_button("", visible=False) for _ in range(ROWS)]
            self._more = gui.add_html("", visible=False)
        for index, row in enumerate(self._rows):
            row.on_click(lambda _, index=index: self._click(index))

    def update(self, survey: Survey, look: Look) -> None:
        """Update the rows."""
        if survey["tree"] is not None:
            self._items = {item["handle"]: item for item in robots_first(survey["tree"])}
            self._parents = {item["parent"] for item in survey["tree"]}
            self._dull = without_bodies(survey["tree"])
            self._version = survey["tree_version"]
        selection = [handle for handle in look["selection"] if handle in self._items]
        if selection != self._selection:
            self._selection = selection
            self._reveal(selection)
        query = self._search.value.strip()
        drawn = (self._version, query, tuple(selection), tuple(self._is_open.items()))
        if drawn != self._drawn:
            self._drawn = drawn
            self._draw(query)

    def close(self) -> None:
        """Do nothing."""

    # --- actions of users; on threads of viser's -------------------------------------------------

    def _click(self, index: int) -> None:
        if index >= len(self._shown):
            return  # it has just gone
        item = self._shown[index]
        handle = item["handle"]
        if self._selection == [handle] and handle in self._parents:
            self._is_open[_key(item)] = not self._opens(item)
        else:
            self._hands.do(lambda client: make(client, lambda calls: calls.simxSetObjectSelection([handle])))

    # --- rows ------------------------------------------------------------------------------------

    def _draw(self, query: str) -> None:
        found = list(self._matches(query) if query else self._unfolded())
        self._shown = found[:ROWS]
        for row, item in zip(self._rows, self._shown, strict=False):
            is_selected = item["handle"] in self._selection
            put(
                row,
                label=_match(item) if query else self._branch(item),
                icon=viser.Icon.CHECK if is_selected else None,
                visible=True,
            )
        for row in self._rows[len(self._shown) :]:
            put(row, visible=False)
        note = ""
        if len(found) > ROWS:
            note = f"and {len(found) - ROWS} more; search for them by name"
        elif not found:
            note = "nothing matches" if query else "the scene is empty"
        put(self._more, content=f"<div style='{_SMALL}'>{note}</div>", visible=bool(note))
        shown = "".join(self._description(self._items[each]) for each in self._selection[:_DETAILS])
        if len(self._selection) > _DETAILS:
            shown += f"and {len(self._selection) - _DETAILS} more"
        put(self._details, content=f"<div style='{_SMALL}'>{shown}</div>", visible=bool(shown))

    def _unfolded(self) -> Iterator[SceneItem]:
        """Yield the objects in tree order, without those below folded ones."""
        folded: int | None = None
        for item in self._items.values():
            if folded is not None and item["depth"] > folded:
                continue
            folded = None if self._opens(item) else item["depth"]
            yield item

    def _matches(self, query: str) -> Iterator[SceneItem]:
        """Yield the objects whose name has the words first, then those that match otherwise."""
        words = query.casefold().split()
        by_name = [item for item in self._items.values() if _has(item["name"], words)]
        named = {item["handle"] for item in by_name}
        yield from by_name
        for item in self._items.values():
            texts = f"{item['path']} {item['type']} {item['joint']}"
            if item["handle"] not in named and (_has(texts, words) or words == [str(item["handle"])]):
                yield item

    def _opens(self, item: SceneItem) -> bool:
        opens = item["depth"] < _OPEN_DEPTH and not item["is_model"] and item["handle"] not in self._dull
        return self._is_open.get(_key(item), opens)

    def _reveal(self, handles: Sequence[int]) -> None:
        """Open the objects in which these are folded."""
        for handle in handles:
            parent = self._items[handle]["parent"]
            while parent in self._items:
                item = self._items[parent]
                if not self._opens(item):
                    self._is_open[_key(item)] = True
                parent = item["parent"]

    def _branch(self, item: SceneItem) -> str:
        sign = "\u2007 "
        if item["handle"] in self._parents:
            sign = "▾ " if self._opens(item) else "▸ "
        return f"{_INDENT * item['depth']}{sign}{_row(item)}"

    @staticmethod
    def _description(item: SceneItem) -> str:
        ask = f"vrep.simxGetObjectHandle(client, {item['name']!r}, vrep.simx_opmode_blocking)"
        parent = "none" if item["parent_name"] is None else f"{item['parent_name']} ({item['parent']})"
        facts = {"handle": item["handle"], "type": _kind(item), "path": item["path"], "parent": parent}
        lines = "".join(f"<br>{name}: {html.escape(str(value))}" for name, value in facts.items())
        return (
            f"<p style='margin:0.3em 0'><b>{html.escape(item['name'])}</b>{lines}<br>"
            f"<code style='user-select:all;overflow-wrap:anywhere'>{html.escape(ask)}</code></p>"
        )


_SMALL = "padding:0 0.75em 0.5em;font-size:0.85em;overflow-wrap:anywhere"


def robots_first(tree: Sequence[SceneItem]) -> list[SceneItem]:
    """Return the tree with the top objects in the order in which users look for them, the objects below unchanged.

    First objects with joints, those with the most joints first; then other bodies, then other objects with shapes, such
    as a floor; last cameras, lights and dummies.
    """
    families: list[list[SceneItem]] = []
    for item in tree:
        if item["depth"] == 0 or not families:
            families.append([])
        families[-1].append(item)

    def rank(family: list[SceneItem]) -> tuple[int, bool, bool]:
        joints = sum(bool(item["joint"]) for item in family)
        is_body = family[0]["element"] == "body" and family[0]["type"] == "shape"
        return -joints, not is_body, not any(item["type"] == "shape" for item in family)

    return [item for family in sorted(families, key=rank) for item in family]


def without_bodies(tree: Sequence[SceneItem]) -> set[int]:
    """Return the objects with only cameras, lights and dummies below them."""
    parent_of = {item["handle"]: item["parent"] for item in tree}
    dull = set(parent_of)
    for item in tree:
        if item["type"] in ("camera", "light", "dummy"):
            continue
        above = item["parent"]
        while above in dull:
            dull.discard(above)
            above = parent_of[above]
    return dull


def _key(item: SceneItem) -> tuple[int, str]:
    return item["handle"], item["name"]


def _has(text: str, words: Sequence[str]) -> bool:
    folded = text.casefold()
    return all(word in folded for word in words)


def _kind(item: SceneItem) -> str:
    return f"{item['joint']} {item['type']}" if item["joint"] else item["type"]


def _row(item: SceneItem) -> str:
    return f"{item['name']}  ·  {_kind(item)}  ·  {item['handle']}"


def _match(item: SceneItem) -> str:
    return f"{_row(item)}  ·  {item['path']}"
