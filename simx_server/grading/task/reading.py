"""Read values of a TOML file; an error names the line, what is wrong and what is valid."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn, cast

from simx_client.protocol.nearest import did_you_mean

MOST_BYTES = 1 << 20
"""Of the file."""

_MISSING = object()


class TaskError(Exception):
    """A task that cannot be used; the text names file and line, what is wrong, and what is valid."""


class TaskFile:
    """The text of a file, to find the lines of its keys."""

    def __init__(self, path: Path) -> None:
        """Read a file. Raises TaskError."""
        self.path = path
        try:
            data = path.read_bytes()
            if len(data) > MOST_BYTES:
                raise TaskError(f"{path}: a task has at most {MOST_BYTES} bytes, not {len(data)}")
            text = data.decode("utf-8")
            self.values: Mapping[str, Any] = tomllib.loads(text)
        except OSError as problem:
            raise TaskError(f"{path} cannot be read: {problem.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as problem:
            raise TaskError(f"{path} is not a TOML file: {problem}") from None
        self._lines = text.splitlines()

    def line(self, table: str, number: int, key: str) -> int:
        """Return the line of a key, or of its table, from 1.

        Args:
            table: its name as in brackets; empty for the first part of the file.
            number: which of several tables of this name, from 0.
            key: empty for the table itself.
        """
        seen, within, found = -1, not table, 1
        for at, line in enumerate(self._lines, 1):
            if header := re.match(r"\s*\[{1,2}\s*([^\[\]]+?)\s*\]{1,2}\s*(?:#.*)?$", line):
                if within and not table:
                    break
                seen += header[1] == table
                within = header[1] == table and seen == number
                found = at if within else found
            elif within and key and re.match(rf"""\s*["']?{re.escape(key)}["']?\s*[=.]""", line):
                return at
        # A key of the first part may be a table.
        return self.line(key, 0, "") if key and not table else found

    def fail(self, table: str, number: int, key: str, why: str) -> NoReturn:
        """Raise TaskError with the line; see `line`."""
        where = f"{key}: " if key else f"[{table}]: " if table else ""
        raise TaskError(f"{self.path}, line {self.line(table, number, key)}: {where}{why}")


class Table:
    """A table of the file; each key is read once, and `end` refuses the others."""

    def __init__(self, file: TaskFile, values: Mapping[str, Any], name: str = "", number: int = 0) -> None:
        self._file, self._values, self._name, self._number = file, dict(values), name, number
        self._known: list[str] = []

    def fail(self, key: str, why: str) -> NoReturn:
        """Raise TaskError for a key; empty: for the table."""
        self._file.fail(self._name, self._number, key, why)

    def take(self, key: str, default: Any = _MISSING) -> Any:
        """Return a value of any type."""
        self._known.append(key)
        if key in self._values:
            return self._values[key]
        if default is _MISSING:
            self.fail("", f"{key!r} is missing")
        return default

    def text(self, key: str, default: Any = _MISSING, longest: int = 1000) -> Any:
        """Return a text; the default is returned as it is."""
        value = self.take(key, default)
        if value is default:
            return value
        if not isinstance(value, str) or not value.strip() or len(value) > longest:
            self.fail(key, f"valid is a text of at most {longest} characters, not {value!r:.80}")
        return value

    def number(self, key: str, default: float | None, low: float, high: float, unit: str = "") -> Any:
        """Return a number in a range; the default is returned as it is."""
        value = self.take(key, default)
        if value is default:
            return value
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
        if not is_number or not low <= value <= high:
            self.fail(
                key, f"valid is a number from {low:g} to {high:g}{unit and ' ' + unit}, not {value!r:.80}"
            )
        return float(value)

    def whole(self, key: str, default: int, low: int, high: int) -> int:
        """Return a whole number in a range."""
        value = self.take(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            self.fail(key, f"valid is a whole number from {low} to {high}, not {value!r:.80}")
        return value

    def texts(self, key: str, known: Iterable[str] | None = None) -> tuple[str, ...]:
        """Return a list of texts, none by default.

        Args:
            known: the valid ones; None: all.
        """
        value = self.take(key, ())
        items = cast("list[object]", value) if isinstance(value, list) else None
        if value == ():
            return ()
        if items is None or not all(isinstance(each, str) and each for each in items):
            self.fail(key, f"valid is a list of texts, not {value!r:.80}")
        found = tuple(str(each) for each in items)
        allowed = None if known is None else list(known)
        for each in found if allowed is not None else ():
            assert allowed is not None
            if each not in allowed:
                self.fail(
                    key, f"there is no {each!r}{did_you_mean(each, allowed)}; valid: {', '.join(allowed)}"
                )
        return found

    def table(self, key: str) -> Table:
        """Return a table, an empty one by default."""
        value = self.take(key, {})
        if not isinstance(value, dict):
            self.fail(key, f"valid is a table: write [{key}]")
        return Table(self._file, cast("dict[str, Any]", value), key)

    def tables(self, key: str) -> list[Table]:
        """Return the tables of a list."""
        value = self.take(key, [])
        items = cast("list[object]", value) if isinstance(value, list) else [value]
        if not all(isinstance(each, dict) for each in items):
            self.fail(key, f"valid are tables: write [[{key}]] before each")
        return [
            Table(self._file, cast("dict[str, Any]", each), key, number) for number, each in enumerate(items)
        ]

    def items(self) -> list[tuple[str, Any]]:
        """Return all keys with their values."""
        self._known += self._values
        return list(self._values.items())

    def end(self) -> None:
        """Refuse keys that were not read. Raises TaskError."""
        for key in self._values:
            if key not in self._known:
                known = list(dict.fromkeys(self._known))
                self.fail(key, f"there is no such key{did_you_mean(key, known)}; valid: {', '.join(known)}")
