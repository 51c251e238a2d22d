"""Find the needs of a script's text: functions and constants of `sim` and its like, and modules.

The text is read and not run: comments and strings are skipped, and the rest is taken as a sequence of names and signs.
A name that the script itself defines does not count. Names that are made while the script runs (`sim['get' .. kind]`)
are not found, and a call counts also where the script would never reach it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

_LUA = re.compile(
    r"""(?P<comment> --\[(?P<c>=*)\[ .*? (?:\](?P=c)\]|\Z) | --[^\n]* )
    | (?P<string> \[(?P<s>=*)\[ .*? (?:\](?P=s)\]|\Z) | "(?:\\.|[^"\\\n])*"? | '(?:\\.|[^'\\\n])*'? )
    | (?P<name> [A-Za-z_]\w* )
    | (?P<number> \d[\w.]* )
    | (?P<sign> \.\.\.? | [=~<>]= | \S )""",
    re.VERBOSE | re.DOTALL,
)
_PYTHON = re.compile(
    r'''(?P<comment> \#[^\n]* )
    | (?P<string> [rbfuRBFU]{0,2} (?: """(?:\\.|[^\\])*?(?:"""|\Z) | \'\'\'(?:\\.|[^\\])*?(?:\'\'\'|\Z)
                                     | "(?:\\.|[^"\\\n])*"? | '(?:\\.|[^'\\\n])*'? ) )
    | (?P<name> [A-Za-z_]\w* )
    | (?P<number> \d[\w.]* )
    | (?P<sign> [=!<>]= | \S )''',
    re.VERBOSE | re.DOTALL,
)

_SPACE = re.compile(r"sim(?:[A-Z]\w*|x)?$")
"""Names of namespaces: sim, simIK, simUI ..., and simx, V-REP's remote API for scripts."""

_VERSION = re.compile(r"(sim\w*)-\d+$")
"""A module with a version: sim-2, simUI-1."""

_FLAT = re.compile(r"sim(?:_|rml_|[A-Z])\w+$")
"""Old names: simGetObjectHandle, sim_handle_self."""

_CONSTANTS = ("sim_", "simrml_")
"""Beginnings of old names of constants."""

_OWN_VARIABLES = frozenset({"sim_call_type", "sim_call_arguments"})
"""Variables that V-REP sets for old scripts."""

_LIBRARY = {
    "lua": re.compile(r"(?:io\.\w+|os\.(?:execute|exit|getenv|remove|rename|setlocale|tmpname))$"),
    "python": re.compile(r"(?:os\.(?:system|popen|remove|rename|mkdir|makedirs|kill)|subprocess\.\w+)$"),
}
"""Functions of the languages' libraries that need files or processes, which scripts do not have."""

_FILE = re.compile(r"([\w.-]+)\.lua$")
"""A module given as a file, as in `sim.include('/lua/graph_customization.lua')`."""


@dataclass(frozen=True)
class Needs:
    """The needs of one text."""

    members: frozenset[str] = frozenset()
    """Functions and constants with their namespace: `sim.getObject`, `simUI.create`. Old names have the new form; of
    the language's own library those that need files or processes: `io.open`.
    """
    modules: frozenset[str] = frozenset()
    """Modules that it requires, without those that are namespaces by their names."""

    def missing(self, offered: Mapping[str, frozenset[str]], modules: frozenset[str]) -> list[str]:
        """Return what is not there, sorted: members as `sim.x`, modules as `require 'x'`.

        Args:
            offered: functions and constants that work, per namespace.
            modules: modules that the server has.
        """
        absent = {
            each for each in self.members if each.partition(".")[2] not in offered.get(_space(each), ())
        }
        return sorted(absent) + [f"require '{each}'" for each in sorted(self.modules - modules)]


def needs_of(text: str, language: str = "lua") -> Needs:
    """Return the needs of a script's text; `language` is lua or python."""
    tokens = _tokens(text, _PYTHON if language == "python" else _LUA)
    reading = _Reading(tokens, _LIBRARY.get(language, _LIBRARY["lua"]))
    return Needs(frozenset(reading.members), frozenset(reading.modules))


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str


_END = _Token("sign", "")


def _tokens(text: str, pattern: re.Pattern[str]) -> list[_Token]:
    found: list[_Token] = []
    for match in pattern.finditer(text):
        kind = match.lastgroup or ""
        kind = next(
            each for each in ("comment", "string", "name", "number", "sign") if match[each] is not None
        )
        if kind != "comment":
            found.append(_Token(kind, match[0]))
    return found


@dataclass
class _Reading:
    """One pass over the tokens of a text."""

    tokens: list[_Token]
    library: re.Pattern[str]
    members: set[str] = field(default_factory=set[str])
    modules: set[str] = field(default_factory=set[str])
    spaces: dict[str, str] = field(default_factory=dict[str, str])
    """Variables that stand for a namespace, to its name."""
    defined: set[str] = field(default_factory=set[str])
    """Names that the script defines: plain ones, and members such as `sim.mine`."""

    def __post_init__(self) -> None:
        chains = list(self._chains())
        for chain, start, end in chains:
            self._define(chain, start, end)
        for chain, _, end in chains:
            self._use(chain, end)
        self.members -= self.defined

    def _at(self, place: int) -> _Token:
        return self.tokens[place] if 0 <= place < len(self.tokens) else _END

    def _chains(self) -> list[tuple[tuple[str, ...], int, int]]:
        """Return each name with the names behind its dots, and the places of its first token and behind its last."""
        found: list[tuple[tuple[str, ...], int, int]] = []
        place = 0
        while place < len(self.tokens):
            is_member = place > 0 and self.tokens[place - 1].text in (".", ":")
            if self.tokens[place].kind != "name" or is_member:
                place += 1
                continue
            end = place + 1
            while self._at(end).text == "." and self._at(end + 1).kind == "name":
                end += 2
            names = tuple(each.text for each in self.tokens[place:end:2])
            found.append((names[1:] if names[0] == "self" and len(names) > 1 else names, place, end))
            place = end
        return found

    def _define(self, chain: tuple[str, ...], start: int, end: int) -> None:
        name = ".".join(chain)
        before, behind = self._at(start - 1).text, self._at(end)
        if before in ("function", "def") or behind.text == "=":
            space = self._assigned_space(end + 1) if behind.text == "=" else None
            if space is not None and len(chain) == 1:
                self.spaces[name] = space
            else:
                self.defined.add(name)
        elif before in ("local", "for"):
            self.defined.add(name)

    def _assigned_space(self, place: int) -> str | None:
        """Return the namespace that stands at this place: its name alone, or a call of `require`."""
        first = self._at(place)
        if first.text == "require":
            module = self._argument(place + 1)
            return _namespace(module) if module is not None else None
        is_alone = (
            first.kind == "name"
            and _SPACE.match(first.text)
            and self._at(place + 1).text not in (".", "(", ":")
        )
        return first.text if is_alone else None

    def _argument(self, place: int) -> str | None:
        """Return the single text argument of a call whose bracket, or text, is at this place."""
        given = self._at(place + 1 if self._at(place).text == "(" else place)
        return given.text.strip("\"'[]=") if given.kind == "string" else None

    def _use(self, chain: tuple[str, ...], end: int) -> None:
        name = chain[0]
        if chain == ("require",) or chain == ("sim", "include"):
            self._require(self._argument(end))
        whole = ".".join(chain[:2])
        if self.library.match(whole) and self._is_called(end) and name not in self.defined:
            self.members.add(whole)
        elif len(chain) > 1:
            space = self.spaces.get(name, name)
            if _SPACE.match(space) and name not in self.defined:
                self.members.add(f"{space}.{chain[1]}")
        elif self._is_old_name(name, end):
            self.members.add(_new_name(name) or name)

    def _is_old_name(self, name: str, end: int) -> bool:
        """Return whether a name without dots is an old one of the server: a function that is called, or a constant."""
        own = name in self.defined or name in _OWN_VARIABLES or name in self.spaces
        return bool(_FLAT.match(name)) and not own and (self._is_called(end) or name.startswith(_CONSTANTS))

    def _is_called(self, end: int) -> bool:
        """Return whether a call starts behind a name: with a bracket, or a text or table as Lua's only argument."""
        return self._at(end).text in ("(", "{") or self._at(end).kind == "string"

    def _require(self, module: str | None) -> None:
        if module is None:
            return
        file = _FILE.search(module)
        name = file[1] if file else module
        if _namespace(name) is None:
            self.modules.add(name)


def _namespace(module: str) -> str | None:
    versioned = _VERSION.match(module)
    name = versioned[1] if versioned else module
    return name if _SPACE.match(name) else None


def _new_name(flat: str) -> str | None:
    """Return the form with a namespace of an old name; None for other names."""
    if not _FLAT.match(flat):
        return None
    if flat.startswith(_CONSTANTS):
        return f"sim.{flat.removeprefix('sim').removeprefix('_')}"
    if flat.startswith("simRML"):
        return f"sim.rml{flat.removeprefix('simRML')}"
    return f"sim.{flat[3].lower()}{flat[4:]}"


def _space(member: str) -> str:
    return member.partition(".")[0]
