"""Report of an import, for the person who opens the file: the approximated and missing parts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field

from .script_needs import Needs

_FEW = 6
"""Names that a line shows; it counts the others."""


@dataclass
class Rehearsal:
    """A short run of the scripts, in a separate process."""

    seconds: float = 0.0
    """Simulated time of the run."""
    stops: list[str] = field(default_factory=list[str])
    """Sentences, each with a script that an error stops, and the error."""
    ended_by: str = ""
    """Why the run was ended early; later stops are unknown."""

    def as_text(self) -> str:
        """Return the section for people."""
        when = f"in the first {self.seconds:g} s of a run" if self.seconds else "at the start of a run"
        if not self.stops:
            text = f"no script is stopped {when}"
        else:
            text = _section(f"scripts that an error stops {when}", self.stops)
        return f"{text}\n  (the run was ended early: {self.ended_by})" if self.ended_by else text


@dataclass
class Report:
    """The notes of one import; each sentence is about one matter, and names the objects concerned."""

    file: str
    version: str = ""
    objects: Counter[str] = field(default_factory=Counter[str])
    """Number of objects by kind."""
    approximated: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    """Sentence to the names of the objects it is about."""
    left_out: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    needs: dict[str, Needs] = field(default_factory=dict[str, Needs])
    """Needs of each script, by a name of the script for people."""
    missing_functions: Counter[str] = field(default_factory=Counter[str])
    """Functions, constants and modules that the scripts need and the server lacks, with the number of scripts.

    `simx_server/sim_api/listing/lacking.py` fills it.
    """
    rehearsal: Rehearsal | None = None
    """The start of its scripts; None if they were not started."""
    faults: list[str] = field(default_factory=list[str])
    """Sentences about values and records of the file that cannot be meant: defaults are in their place."""
    skipped: dict[str, int] = field(default_factory=dict[str, int])
    """Tags of records that are not read, and how many the file has."""
    credits: list[str] = field(default_factory=list[str])
    """Acknowledgements in the file."""

    def approximate(self, sentence: str, *names: str) -> None:
        """Note what the scene has only in a similar form."""
        self.approximated.setdefault(sentence, []).extend(names)

    def leave_out(self, sentence: str, *names: str) -> None:
        """Note what the scene does not have."""
        self.left_out.setdefault(sentence, []).extend(names)

    def credit(self, text: str) -> None:
        """Note an acknowledgement of the file once."""
        plain = " ".join(text.split())
        if plain and plain not in self.credits:
            self.credits.append(plain)

    def as_text(self) -> str:
        """Return the whole report for people, a section per kind of note that there is."""
        program = f", saved by version {self.version}" if self.version else ""
        sections = [f"{self.file}{program}: {_counted(self.objects)}"]
        for title, notes in (("approximated", self.approximated), ("left out", self.left_out)):
            if notes:
                sections.append(_section(title, [_line(*note) for note in notes.items()]))
        if not (self.approximated or self.left_out or self.faults or self.skipped):
            sections.append("nothing is approximated or left out")
        if self.faults:
            sections.append(_section("faults in the file", self.faults))
        if self.skipped:
            sections.append("records that are not read: " + _counted(self.skipped))
        if self.missing_functions:
            wanted = [f"{name} ({_scripts(count)})" for name, count in _often_first(self.missing_functions)]
            sections.append(_section("scripts need, but this server lacks", wanted))
        elif self.needs:
            sections.append(f"scripts: {len(self.needs)}, without a missing function")
        if self.rehearsal is not None:
            sections.append(self.rehearsal.as_text())
        if self.credits:
            sections.append(_section("credits in the file", self.credits))
        return "\n\n".join(sections)

    def summary(self) -> str:
        """Return the report in one line for a log."""
        parts = [f"'{self.file}' has {_counted(self.objects)}"]
        if self.approximated:
            parts.append("approximated: " + ", ".join(self.approximated))
        if self.left_out:
            parts.append("left out: " + ", ".join(self.left_out))
        if self.faults:
            parts.append(f"faults in the file: {len(self.faults)}")
        if self.missing_functions:
            names = [name for name, _ in _often_first(self.missing_functions)]
            parts.append(f"scripts need and the server lacks: {_some(names)}")
        return "; ".join(parts)

    def as_record(self) -> dict[str, object]:
        """Return the report for programs, ready for json.dumps."""
        return {
            "file": self.file,
            "version": self.version,
            "objects": dict(self.objects),
            "approximated": self.approximated,
            "left_out": self.left_out,
            "faults": self.faults,
            "skipped_records": self.skipped,
            "scripts": len(self.needs),
            "missing_functions": dict(self.missing_functions),
            "rehearsal": None if self.rehearsal is None else asdict(self.rehearsal),
            "credits": self.credits,
        }


def _counted(objects: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in _often_first(objects)) or "no objects"


def _often_first(counts: Mapping[str, int]) -> list[tuple[str, int]]:
    return sorted(counts.items(), key=lambda each: (-each[1], each[0]))


def _line(sentence: str, names: Sequence[str]) -> str:
    unique = list(dict.fromkeys(names))
    return f"{sentence}: {_some(unique)}" if unique else sentence


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(names[:_FEW])
    return shown if len(names) <= _FEW else f"{shown} and {len(names) - _FEW} more"


def _scripts(count: int) -> str:
    return "1 script" if count == 1 else f"{count} scripts"


def _section(title: str, lines: Iterable[str]) -> str:
    return "\n".join([f"{title}:", *(f"  {line}" for line in lines)])
