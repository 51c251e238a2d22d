"""Signals: their names, types and values, to set and clear; plots; the streams that clients have armed."""

from __future__ import annotations

import codecs
from collections.abc import Callable, Iterable, Sequence

import viser

from simx_client import Client
from simx_server.viewer.messages import Look, StringView, Survey
from simx_server.viewer.messages import Signals as Values
from simx_server.viewer.page.link import Hands
from simx_server.viewer.page.mirror import Mirror

from .elements import harmless
from .plots import Plots

_INTEGER: str = "integer"
_FLOAT: str = "float"
_STRING: str = "string"
_NEW: str = "(a new one)"
_MOST_ROWS = 100
_MOST_LETTERS = 300
_MOST_BYTES = 32
_INTEGERS = range(-(1 << 31), 1 << 31)
_NONE = "<i>none</i>"


class Signals:
    """The tab."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, mirror: Mirror) -> None:
        self._hands = hands
        self._values: Values = {"integers": {}, "floats": {}, "strings": {}, "count": 0}
        with gui.add_folder("Signals"):
            self._table = gui.add_html(_NONE)
            self._which: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Signal", (_NEW,), hint="one that is set, to change or clear it"
            )
            self._name = gui.add_text("Name", "")
            self._kind: viser.GuiDropdownHandle[str] = gui.add_dropdown("Type", (_INTEGER, _FLOAT, _STRING))
            self._value = gui.add_text("Value", "")
            put = gui.add_button("Set signal", icon=viser.Icon.CHECK)
            clear = gui.add_button("Clear signal", icon=viser.Icon.TRASH)
        self._plots = Plots(gui, mirror)
        with gui.add_folder("Streams"):
            self._streams = gui.add_html(_NONE)
        self._which.on_update(lambda _: self._choose())
        put.on_click(lambda _: self._act(put_signal))
        clear.on_click(lambda _: self._act(clear_signal))

    def update(self, survey: Survey, look: Look) -> None:
        """Update the table."""
        self._values = values = survey["signals"]
        rows = _rows(values)
        self._table.content = _as_table(("name", "type", "value"), rows, values["count"])
        options = (_NEW, *(_label(name, kind) for name, kind, _ in rows))
        if self._which.options != options:
            self._which.options = options
        self._plots.update(survey, look)
        self._streams.content = _as_table(
            ("client", "command", "arguments"),
            [(each["client"], each["command"], each["arguments"]) for each in survey["streams"]],
            len(survey["streams"]),
        )

    def close(self) -> None:
        """Do nothing."""

    def _choose(self) -> None:
        """Put the chosen signal into the fields below. A thread of viser's."""
        values = self._values
        texts = {name: _text(value) for name, value in values["strings"].items()}
        found = [(name, _INTEGER, str(value)) for name, value in values["integers"].items()]
        found += [(name, _FLOAT, f"{value:.9g}") for name, value in values["floats"].items()]
        # A value shown as bytes or in part must not be set again by mistake.
        found += [(name, _STRING, "" if remark else text) for name, (text, remark) in texts.items()]
        for name, kind, value in found:
            if _label(name, kind) == self._which.value:
                self._name.value, self._kind.value, self._value.value = name, kind, value

    def _act(self, action: Callable[[Client, str, str, str], None]) -> None:
        """Run an action with the present fields."""
        name, kind, value = self._name.value, self._kind.value, self._value.value
        self._hands.do(lambda client: action(client, name, kind, value))


def put_signal(client: Client, name: str, kind: str, value: str) -> None:
    """Set a signal from typed text. Raises ValueError: the text is not such a number; SimxError."""
    if kind == _STRING:
        client.signals.strings[name] = value
    elif kind == _FLOAT:
        try:
            client.signals.floats[name] = float(value)
        except ValueError:
            raise ValueError(f"{value!r} is no number; type one such as 0.25 or 1e-3") from None
    else:
        try:
            number = int(value, 0)
        except ValueError:
            raise ValueError(f"{value!r} is no integer; type one such as 3, -1 or 0x10") from None
        if number not in _INTEGERS:
            raise ValueError(
                f"{number} has more than 32 bits; an integer signal is -2147483648 to 2147483647"
            )
        client.signals.ints[name] = number


def clear_signal(client: Client, name: str, kind: str, value: str) -> None:
    """Clear the signal of this kind. Raises ValueError: no name; SimxError."""
    signals = client.signals
    del {_INTEGER: signals.ints, _FLOAT: signals.floats, _STRING: signals.strings}[kind][name]


def _rows(values: Values) -> list[tuple[str, str, str]]:
    """Return (name, kind, value), by name."""
    rows = [(name, _INTEGER, str(value)) for name, value in values["integers"].items()]
    rows += [(name, _FLOAT, f"{value:.6g}") for name, value in values["floats"].items()]
    rows += [(name, _STRING, " ".join(_text(value)).rstrip()) for name, value in values["strings"].items()]
    return sorted(rows)


def _text(value: StringView) -> tuple[str, str]:
    """Return a string signal as text, or its bytes if it is not a text; and a note about it."""
    beginning, size = value["beginning"], value["size"]
    try:
        # The excerpt may end within a letter.
        text = codecs.getincrementaldecoder("utf-8")().decode(beginning)
    except UnicodeDecodeError:
        text = None
    if text is None or not all(letter.isprintable() or letter in "\n\t" for letter in text):
        return beginning[:_MOST_BYTES].hex(" "), f"({size} bytes)"
    return text, f"… ({size} bytes)" if size > len(beginning) else ""


def _label(name: str, kind: str) -> str:
    return f"{name} ({kind})"


def _as_table(heads: Iterable[str], rows: Sequence[Sequence[str]], count: int) -> str:
    """Return HTML; the texts are of clients, so each is escaped. `count`: number of rows, including omitted ones."""
    if not rows:
        return f"<div style='padding:0 1em'>{_NONE}</div>"
    style = "text-align:left;min-width:4em;padding:0.1em 0.6em 0.1em 0;vertical-align:top"
    lines = ["".join(f"<th style='{style}'>{head}</th>" for head in heads)]
    for row in rows[:_MOST_ROWS]:
        lines.append(
            "".join(
                f"<td style='{style};overflow-wrap:anywhere'>{harmless(cell, _MOST_LETTERS)}</td>"
                for cell in row
            )
        )
    table = "".join(f"<tr>{line}</tr>" for line in lines)
    shown = min(len(rows), _MOST_ROWS)
    more = f"and {count - shown} more" if count > shown else ""
    return f"<div style='font-size:0.85em;padding:0 1em'><table>{table}</table>{more}</div>"
