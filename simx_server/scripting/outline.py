"""Quick view of a script's text without running it: its functions and the signals that it names.

The text is searched with patterns. Functions created in other ways (by `load`, by a table of functions) are not
found.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_LUA_FUNCTION = re.compile(
    r"\bfunction\s+([A-Za-z_]\w*)\s*\(|^\s*([A-Za-z_]\w*)\s*=\s*function\s*\(", re.MULTILINE
)
_LOCAL = re.compile(r"\blocal\s+$")
_PYTHON_FUNCTION = re.compile(r"^def\s+([A-Za-z_]\w*)\s*\(", re.MULTILINE)
_SIGNAL = re.compile(r"\bsim\.?\w*[sS]ignal\s*\(\s*(['\"])(.*?)\1\s*(\.\.|\+|,|\))")
_LUA_COMMENT = re.compile(r"--\[\[.*?\]\]|--[^\n]*", re.DOTALL)
_PYTHON_COMMENT = re.compile(r"^\s*#[^\n]*", re.MULTILINE)


def functions_in(text: str, language: str) -> list[str]:
    """Return names of the functions that a client or another script may call, in the order of the text."""
    plain = _without_comments(text, language)
    if language == "python":
        return _once(_PYTHON_FUNCTION.findall(plain))
    return _once(
        found[1] or found[2]
        for found in _LUA_FUNCTION.finditer(plain)
        if not _LOCAL.search(plain, 0, found.start())
    )


def signals_in(text: str, language: str) -> list[str]:
    """Return names of signals that the text sets or reads; a name composed of parts ends with ``*``."""
    found = _SIGNAL.finditer(_without_comments(text, language))
    return _once(each[2] + ("*" if each[3] in ("..", "+") else "") for each in found)


def _without_comments(text: str, language: str) -> str:
    return (_PYTHON_COMMENT if language == "python" else _LUA_COMMENT).sub("", text)


def _once(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))
