"""Tables and trees of ``simUI``. The web viewer shows them, without a way to edit them."""

from __future__ import annotations

import msgpack

from simx_server.errors import CommandError, Unsupported
from simx_server.parts.user_interface.contents.tree import Item, Tree
from simx_server.parts.user_interface.widgets import MAX_TEXT, Widget

from .sim_ui import UiPart

MAX_CELLS = 10_000
"""Most cells of a table, and most items of a tree."""

_WIDTHS, _HEIGHTS = "widths", "heights"
"""Sizes of columns and rows by number: least and greatest, in pixels."""

_LARGEST = 10_000


class UiTableFunctions(UiPart, effect="changes"):
    """Tables. Rows and columns are counted from 0."""

    def _table(self, handle: int, id: int) -> Widget:
        return self._widget(handle, id, "table")

    def _resize(self, table: Widget, rows: int, columns: int) -> None:
        if rows < 0 or columns < 0 or rows * columns > MAX_CELLS or max(rows, columns) > MAX_CELLS:
            raise Unsupported(f"a table has at most {MAX_CELLS} cells, not {rows} rows of {columns}")
        kept = table.kept
        for names, count in ((kept["names"], rows), (kept["columns"], columns)):
            names[:] = names[:count] + [""] * (count - len(names))
        kept["rows"] = [row[:columns] + [""] * (columns - len(row)) for row in kept["rows"][:rows]]
        kept["rows"] += [[""] * columns for _ in range(rows - len(kept["rows"]))]

    def _cell(self, table: Widget, row: int, column: int) -> list[str]:
        rows, columns = table.kept["rows"], table.kept["columns"]
        if not (0 <= row < len(rows) and 0 <= column < len(columns)):
            raise Unsupported(
                f"table {table.id} has {len(rows)} rows and {len(columns)} columns, from 0; no cell {row}, {column}"
            )
        return rows[row]

    def getRowCount(self, handle: int, id: int) -> int:
        return len(self._table(handle, id).kept["rows"])

    def setRowCount(self, handle: int, id: int, count: int, _suppress: bool = True) -> None:
        """Set the number of rows; new cells are empty."""
        table = self._table(handle, id)
        self._resize(table, count, len(table.kept["columns"]))

    def getColumnCount(self, handle: int, id: int) -> int:
        return len(self._table(handle, id).kept["columns"])

    def setColumnCount(self, handle: int, id: int, count: int, _suppress: bool = True) -> None:
        """Set the number of columns; new cells are empty."""
        table = self._table(handle, id)
        self._resize(table, len(table.kept["rows"]), count)

    def clearTable(self, handle: int, id: int, _suppress: bool = True) -> None:
        """Remove all rows and columns."""
        self._resize(self._table(handle, id), 0, 0)

    def getItem(self, handle: int, id: int, row: int, column: int) -> str:
        """Return the text of a cell."""
        return self._cell(self._table(handle, id), row, column)[column]

    def setItem(self, handle: int, id: int, row: int, column: int, text: str, _suppress: bool = True) -> None:
        """Set the text of a cell."""
        self._cell(self._table(handle, id), row, column)[column] = text[:MAX_TEXT]

    def setRowHeaderText(self, handle: int, id: int, row: int, text: str) -> None:
        """Set the name of a row."""
        _name(self._table(handle, id).kept["names"], row, text)

    def setColumnHeaderText(self, handle: int, id: int, column: int, text: str) -> None:
        """Set the name of a column."""
        _name(self._table(handle, id).kept["columns"], column, text)

    def insertTableRow(self, handle: int, id: int, index: int) -> None:
        """Insert an empty row before one, or at the end."""
        table = self._table(handle, id)
        self._resize(table, len(table.kept["rows"]) + 1, len(table.kept["columns"]))
        place = min(max(index, 0), len(table.kept["rows"]) - 1)
        table.kept["rows"].insert(place, table.kept["rows"].pop())
        table.kept["names"].insert(place, table.kept["names"].pop())

    def removeTableRow(self, handle: int, id: int, index: int) -> None:
        table = self._table(handle, id)
        if not 0 <= index < len(table.kept["rows"]):
            raise Unsupported(
                f"table {id} has {len(table.kept['rows'])} rows, from 0; {index} is not one of them"
            )
        del table.kept["rows"][index], table.kept["names"][index]

    def insertTableColumn(self, handle: int, id: int, index: int) -> None:
        """Insert an empty column before one, or at the end."""
        table = self._table(handle, id)
        kept = table.kept
        self._resize(table, len(kept["rows"]), len(kept["columns"]) + 1)
        place = min(max(index, 0), len(kept["columns"]) - 1)
        for cells in (kept["columns"], *kept["rows"]):
            cells.insert(place, cells.pop())

    def removeTableColumn(self, handle: int, id: int, index: int) -> None:
        kept = self._table(handle, id).kept
        if not 0 <= index < len(kept["columns"]):
            raise Unsupported(
                f"table {id} has {len(kept['columns'])} columns, from 0; {index} is not one of them"
            )
        for cells in (kept["columns"], *kept["rows"]):
            del cells[index]

    def setItemEditable(self, handle: int, id: int, row: int, column: int, _editable: bool) -> None:
        """Do nothing to an existing cell. Stand-in: the user cannot edit cells."""
        self._cell(self._table(handle, id), row, column)

    def setRowHeight(self, handle: int, id: int, row: int, least: int, most: int | None = None) -> None:
        """Set the least height of a row, and the greatest, in pixels."""
        _put_size(self._table(handle, id), _HEIGHTS, row, least, most)

    def setColumnWidth(self, handle: int, id: int, column: int, least: int, most: int | None = None) -> None:
        """Set the least width of a column of a table or tree, and the greatest, in pixels."""
        _put_size(self._widget(handle, id, "table", "tree"), _WIDTHS, column, least, most)

    def setTableSelection(self, handle: int, id: int, row: int, column: int, suppress: bool = True) -> None:
        """Select a cell. With `suppress` false, the function of `on-selection-change` gets its row and column."""
        table = self._table(handle, id)
        self._cell(table, row, column)
        table.kept["selected"] = (row, column)
        if not suppress:
            self._window(handle).tell(table, "on-selection-change", row, column)

    def saveState(self, handle: int, id: int) -> bytes:
        """Return the widths of columns and heights of rows for restoreState."""
        widget = self._widget(handle, id, "table", "tree")
        return msgpack.packb({key: widget.kept.get(key, {}) for key in (_WIDTHS, _HEIGHTS)})

    def restoreState(self, handle: int, id: int, state: bytes) -> None:
        """Set what saveState has returned."""
        widget = self._widget(handle, id, "table", "tree")
        try:
            told = msgpack.unpackb(state, strict_map_key=False)
            sizes = {
                key: {
                    _checked_size(place): tuple(map(_checked_size, pair)) for place, pair in told[key].items()
                }
                for key in (_WIDTHS, _HEIGHTS)
            }
            if any(
                len(each) > MAX_CELLS or any(len(pair) != 2 for pair in each.values())
                for each in sizes.values()
            ):
                raise ValueError("other sizes")
        except Exception:  # msgpack raises many kinds, and the content may be anything
            raise CommandError("this is not a state that simUI.saveState has returned") from None
        widget.kept.update(sizes)


class UiTreeFunctions(UiPart, effect="changes"):
    """Trees. The web viewer shows the items that are expanded; its user does not select or expand items."""

    def _tree(self, handle: int, id: int) -> Tree:
        return self._widget(handle, id, "tree").tree

    def clearTree(self, handle: int, id: int, _suppress: bool = True) -> None:
        """Remove all items."""
        tree = self._tree(handle, id)
        tree.items.clear()
        tree.selected = None

    def addTreeItem(
        self,
        handle: int,
        id: int,
        item: int,
        texts: list[str],
        parent: int = 0,
        expanded: bool = False,
        _suppress: bool = True,
    ) -> None:
        """Add an item below another one; 0: at the top."""
        tree = self._tree(handle, id)
        if len(tree.items) >= MAX_CELLS:
            raise Unsupported(f"tree {id} has {MAX_CELLS} items already; remove some")
        tree.put(item, Item([text[:MAX_TEXT] for text in texts], parent, expanded))

    def updateTreeItemText(self, handle: int, id: int, item: int, texts: list[str]) -> None:
        """Set the texts of an item."""
        tree = self._tree(handle, id)
        _known(tree, item)
        tree.items[item].texts = [text[:MAX_TEXT] for text in texts]

    def updateTreeItemParent(
        self, handle: int, id: int, item: int, parent: int, _suppress: bool = True
    ) -> None:
        """Put an item below another one; 0: at the top."""
        tree = self._tree(handle, id)
        _known(tree, item)
        tree.move(item, parent)

    def removeTreeItem(self, handle: int, id: int, item: int, _suppress: bool = True) -> None:
        """Remove an item and all below it."""
        tree = self._tree(handle, id)
        _known(tree, item)
        tree.remove(item)

    def setTreeSelection(self, handle: int, id: int, item: int, _suppress: bool = True) -> None:
        """Select an item."""
        tree = self._tree(handle, id)
        _known(tree, item)
        tree.selected = item

    def expandAll(self, handle: int, id: int, _suppress: bool = True) -> None:
        """Show all items."""
        self._tree(handle, id).expand(None)

    def collapseAll(self, handle: int, id: int, _suppress: bool = True) -> None:
        """Show the items at the top alone."""
        self._tree(handle, id).expand(-1)

    def expandToDepth(self, handle: int, id: int, depth: int, _suppress: bool = True) -> None:
        """Expand the items down to a depth; 0: those at the top."""
        self._tree(handle, id).expand(depth)


def _put_size(widget: Widget, key: str, place: int, least: int, most: int | None) -> None:
    sizes = widget.kept.setdefault(key, {})
    if not 0 <= place < MAX_CELLS:
        raise CommandError(f"rows and columns count from 0 to {MAX_CELLS - 1}; {place} is not one of them")
    low = min(max(least, 0), _LARGEST)
    sizes[place] = low, _LARGEST if most is None or most < 0 else min(max(most, low), _LARGEST)


def _checked_size(value: object) -> int:
    """Return a number of pixels or of a row. Raises ValueError."""
    if type(value) is not int or not 0 <= value <= _LARGEST:
        raise ValueError("no size")
    return value


def _name(names: list[str], index: int, text: str) -> None:
    if not 0 <= index < len(names):
        raise Unsupported(f"there are {len(names)} of these, from 0; {index} is not one of them")
    names[index] = text[:MAX_TEXT]


def _known(tree: Tree, item: int) -> None:
    if item not in tree.items:
        raise Unsupported(f"the tree has no item {item}; add it with simUI.addTreeItem")
