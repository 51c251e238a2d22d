"""Tables and trees of ``simUI``. The web viewer shows them, without a way to edit them."""

from __future__ import annotations

from simx_server.errors import Unsupported
from simx_server.parts.user_interface.contents.tree import Item, Tree
from simx_server.parts.user_interface.widgets import MAX_TEXT, Widget

from .sim_ui import UiPart

MAX_CELLS = 10_000
"""Most cells of a table, and most items of a tree."""


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

    def setRowHeight(self, handle: int, id: int, _row: int, _least: int, _most: int | None = None) -> None:
        """Do nothing to an existing table. Stand-in: the web viewer gives cells their size."""
        self._table(handle, id)

    def setColumnWidth(
        self, handle: int, id: int, _column: int, _least: int, _most: int | None = None
    ) -> None:
        """Do nothing to an existing table or tree. Stand-in: the web viewer gives cells their size."""
        self._widget(handle, id, "table", "tree")

    def setTableSelection(
        self, handle: int, id: int, _row: int, _column: int, _suppress: bool = True
    ) -> None:
        """Do nothing to an existing table. Stand-in: no cell is shown as selected."""
        self._table(handle, id)

    def saveState(self, handle: int, id: int) -> bytes:
        """Return the widths of columns. Stand-in: an empty buffer."""
        self._widget(handle, id, "table", "tree")
        return b""

    def restoreState(self, handle: int, id: int, _state: bytes) -> None:
        """Do nothing to an existing table. Stand-in: columns have no widths."""
        self._widget(handle, id, "table", "tree")


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


def _name(names: list[str], index: int, text: str) -> None:
    if not 0 <= index < len(names):
        raise Unsupported(f"there are {len(names)} of these, from 0; {index} is not one of them")
    names[index] = text[:MAX_TEXT]


def _known(tree: Tree, item: int) -> None:
    if item not in tree.items:
        raise Unsupported(f"the tree has no item {item}; add it with simUI.addTreeItem")
