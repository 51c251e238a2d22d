"""The time slider: look at the steps of a run that are kept, at what clients called in each, and go on from one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import msgpack
import viser

from simx_client import Client
from simx_client.protocol.add_ons.past import ADD_ON, GO_ON, KEPT, GoneOn, Kept, PastCall, PastStep
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Hands

from .elements import harmless, put

_FIRST, _BACK, _FORTH, _NOW = "first", "◀", "▶", "now"
_CALL_BACK, _CALL_FORTH = "◀ call", "call ▶"
_MOST_SIGNALS = 12
_LETTERS = 260

_PAST_STYLE = (
    "margin:0.2em 0.9em;padding:0.45em 0.7em;border-left:4px solid #d9480f;background:rgba(217,72,15,0.08);"
    "font-size:0.85em;line-height:1.4"
)
_CALLS_STYLE = (
    "margin:0 0.9em 0.5em;padding:0.2em 0;max-height:15em;overflow:auto;font-size:0.8em;"
    "overflow-wrap:anywhere"
)


class TimeSlider:
    """The slider, and what stands below it while the past is shown.

    `step` is what the page shows; the page gives the answer to `show`. `tell` reports in every browser what a new run
    lacks.
    """

    def __init__(self, gui: viser.GuiApi, hands: Hands, tell: Callable[[str, str], None]) -> None:
        self._hands, self._tell = hands, tell
        self._first = self._last = -1
        self._time_step = 0.0
        self._now: tuple[str, float, int] = ("stopped", 0.0, 0)
        self._past: PastStep | None = None
        self._step: int | None = None
        self._placed = 0
        """Where the page has put the slider; it is elsewhere if a user has just dragged it."""

        self._seeks_call = False
        """Turn to the last call before the step that is shown next, if it has none."""

        self._slider = gui.add_slider(
            "Step",
            min=0,
            max=1,
            step=1,
            initial_value=0,
            disabled=True,
            hint="of this run: drag back to see the past",
        )
        self._buttons = gui.add_button_group(
            "Past",
            (_FIRST, _CALL_BACK, _BACK, _FORTH, _CALL_FORTH, _NOW),
            hint="a step, or the next one with a call",
        )
        self._text = gui.add_html("", visible=False)
        self._go_on = gui.add_button(
            "Go on from here",
            icon=viser.Icon.PLAYER_TRACK_NEXT,
            hint="a new run from the end of this step; later steps are forgotten",
            visible=False,
        )
        self._reads = gui.add_checkbox(
            "Reads and triggers",
            False,
            hint="calls that change nothing, or only ask for a step",
            visible=False,
        )
        self._calls = gui.add_html("", visible=False)
        gui.add_html("<div style='height:0.3em'></div>")
        self._slider.on_update(self._dragged)
        self._buttons.on_click(lambda event: self._jump(event.target.value))
        self._reads.on_update(lambda _: self._show_calls())
        self._go_on.on_click(lambda _: self._start_again())

    @property
    def step(self) -> int | None:
        """Return the past step to show; None: the present."""
        return self._step

    def show(self, asked: int, past: PastStep | None) -> None:
        """Show what belongs to a past step, if it is still the one to show.

        Args:
            asked: the step that was asked for; the user may have turned to another one meanwhile.
            past: of this step, or of the nearest one that is kept; None: none is kept any more.
        """
        if self._step != asked:
            return
        if past is None:
            self.leave()
            return
        self._past = past
        self._step = past["step"]  # of a step that is not kept any more, the nearest one
        self._place(self._step)
        self._show_past(past)
        if self._seeks_call:
            self._seeks_call = False
            if past["call_before"] >= 0 and all(call["only_reads"] for call in past["calls"]):
                self._turn_to(past["call_before"])

    def turn_to(self, step: int) -> None:
        """Show a past step, or the nearest one that is kept. Any thread."""
        self._turn_to(step)

    def leave(self) -> None:
        """Show the present again."""
        self._step = self._past = None
        for element in (self._text, self._go_on, self._reads, self._calls):
            put(element, visible=False)
        self._place(max(self._last, 0))

    def update(self, survey: Survey, look: Look) -> None:
        """Update the range of the slider. A stop shows the present, which it has brought back."""
        kept = survey["past"]
        if kept["now"][0] == "stopped" != self._now[0] and self._step is not None:
            self.leave()
        self._now, self._time_step = kept["now"], survey["time_step"]
        self._first, self._last = kept["first"], kept["last"]
        if self._last < 0:
            if self._step is not None:
                self.leave()
            put(self._slider, min=0, max=1, value=0, disabled=True)
            self._placed = 0
            return
        first, last = self._first, max(self._last, self._first + 1)
        is_present, is_dragged = self._step is None, self._slider.value != self._placed
        if last > self._slider.max:  # the ends never cross, and the value stays between them
            put(self._slider, max=last)
        put(self._slider, min=first)
        put(self._slider, max=last, disabled=False)
        if not is_dragged:
            self._placed = self._slider.value  # between the ends
        if is_present and self._step is None:
            self._place(self._last)
        elif self._past is not None:
            self._show_past(self._past)

    def close(self) -> None:
        """Do nothing."""

    # --- actions of users; on threads of viser's -------------------------------------------------

    def _dragged(self, event: viser.GuiEvent[viser.GuiSliderHandle[int]]) -> None:
        if event.client is not None:  # otherwise `update` has moved it
            self._placed = int(event.target.value)
            self._turn_to(self._placed)

    def _place(self, step: int) -> None:
        """Move the slider, unless a user has just dragged it: the event that says so is on its way and reads it."""
        if self._slider.value == self._placed:
            put(self._slider, value=step)
            self._placed = step

    def _turn_to(self, step: int) -> None:
        if self._last < 0:
            return
        if step >= self._last:
            self.leave()
        else:
            self._step = max(step, self._first)
            self._place(self._step)

    def _jump(self, button: str) -> None:
        present = self._last if self._step is None else self._step
        past = self._past
        match button:
            case "first":
                self._turn_to(self._first)
            case "◀":
                self._turn_to(present - 1)
            case "▶":
                self._turn_to(present + 1)
            case "◀ call" | "call ▶" if past is not None and self._step is not None:
                found = past["call_before" if button == _CALL_BACK else "call_after"]
                if found >= 0:
                    self._turn_to(found)
            case "◀ call":
                self._seeks_call = True  # the answer to this says where the last call is
                self._turn_to(present - 1)
            case _:
                self.leave()

    def _start_again(self) -> None:
        step = self._step
        if step is not None:
            self._hands.do(lambda client: self._ask_for_run(client, step))

    def _ask_for_run(self, client: Client, step: int) -> None:
        client.simulation.pause()  # so that no further step slides out of the kept time
        kept: Kept = _answer(client, KEPT)
        first = max(step, kept["first"])
        gone: GoneOn = _answer(client, GO_ON, first)
        self.leave()
        text = f"Step {step} is not kept any more. " if first > step else ""
        text += f"It is paused at step {gone['step']}, {gone['time']:.2f} s. Press Start to go on."
        if gone["restarted"]:
            names = ", ".join(gone["restarted"])
            text += f" These scripts have started again, without the values of their variables: {names}."
        self._tell("A new run", text)

    # --- what is shown ---------------------------------------------------------------------------

    def _show_past(self, past: PastStep) -> None:
        state, time, steps = self._now
        step, then = past["step"], past["time"]
        where = f"<b>The past: step {step}, {then:.2f} s.</b>"
        if steps > step:
            where += f" That is {time - then:.2f} s ago; the simulation {_DOES[state]}."
        elif state == "stopped":
            where += " The run has ended."
        lines = [where, "The 3-D view shows this step, the tabs show the present."]
        if past["signals"]:
            shown = [f"{name}&nbsp;=&nbsp;{_value(value)}" for name, value in past["signals"].items()]
            more = f", and {len(shown) - _MOST_SIGNALS} more" if len(shown) > _MOST_SIGNALS else ""
            lines.append(f"Signals: {', '.join(shown[:_MOST_SIGNALS])}{more}")
        put(self._text, content=f"<div style='{_PAST_STYLE}'>{'<br>'.join(lines)}</div>", visible=True)
        for element in (self._go_on, self._reads, self._calls):
            put(element, visible=True)
        self._show_calls()

    def _show_calls(self) -> None:
        past = self._past
        if past is not None:
            put(self._calls, content=calls_as_html(past, with_reads=self._reads.value))


def _answer(client: Client, function: str, *integers: int) -> Any:
    """Call a function of the server's add-on and return its answer."""
    answer = client.call(function, ADD_ON, integers, script_type=ADD_ON_TYPE)
    return msgpack.unpackb(answer.buffer, strict_map_key=False)


_DOES: Mapping[str, str] = MappingProxyType(
    {"running": "runs on", "paused": "is paused", "stopped": "is stopped"}
)


def _value(value: object) -> str:
    return harmless(f"{value:.6g}" if isinstance(value, float) else str(value), 40)


def calls_as_html(past: PastStep, *, with_reads: bool) -> str:
    """Return the calls of a step, one below the other; the texts are of clients, so they are escaped."""
    calls = [call for call in past["calls"] if with_reads or not call["only_reads"]]
    hidden = len(past["calls"]) - len(calls)
    notes: list[str] = []
    if not calls:
        notes.append(
            "No client changed anything before this step." if hidden else "No client called anything."
        )
    if hidden:
        notes.append("1 read or trigger." if hidden == 1 else f"{hidden} reads and triggers.")
    if past["calls_left_out"]:
        notes.append(f"{past['calls_left_out']} further calls of this step are not kept.")
    clients = [None, *(call["client"] for call in calls)]  # one that calls several times is named once
    rows = "".join(
        _row(call, is_named=call["client"] != before) for call, before in zip(calls, clients, strict=False)
    )
    note = f"<div style='opacity:0.7;padding:0.1em 0'>{' '.join(notes)}</div>" if notes else ""
    return f"<div style='{_CALLS_STYLE}'>{rows}{note}</div>"


def _row(call: PastCall, *, is_named: bool) -> str:
    results = harmless(call["results"], _LETTERS)
    colour = "color:#e03131" if call["has_failed"] else "opacity:0.75"
    answer = f"<div style='{colour};padding-left:1.2em'>→ {results}</div>" if results else ""
    client = f"<div style='opacity:0.7'>{harmless(call['client'], 60)}</div>" if is_named else ""
    return (
        f"<div style='padding:0.15em 0;border-bottom:1px solid rgba(128,128,128,0.2)'>{client}"
        f"<code>{harmless(call['call'], _LETTERS)}</code>{answer}</div>"
    )
