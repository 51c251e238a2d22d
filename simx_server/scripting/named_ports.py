"""Ports at which a script's text starts the remote API."""

from __future__ import annotations

import re

_COMMENT = re.compile(rb"--\[(=*)\[.*?\]\1\]|--[^\n]*", re.DOTALL)
_START = re.compile(rb"\bsim(?:RemoteApi\s*\.\s*start|ExtRemoteApiStart)\s*\(\s*(\w{1,100})\s*[,)]")
_HIGHEST = 65535


def named_ports(text: bytes) -> list[int]:
    """Return the ports in calls such as `simRemoteApi.start(19999)`.

    A variable counts if the text sets it to one number and nothing else, as in `local port = 20000`.
    """
    code = _COMMENT.sub(b"", text)
    found = [_number(code, call[1]) for call in _START.finditer(code)]
    return [port for port in found if port is not None and 0 < port <= _HIGHEST]


def _number(code: bytes, word: bytes) -> int | None:
    """Return the number that a word of the text stands for; None if that is not known."""
    if word.isdigit():
        return int(word) if len(word) <= 5 else None
    values = {
        each[1] for each in re.finditer(rb"(?<![\w.])%b\s*=(?!=)\s*(\w*[^\n;]*)" % re.escape(word), code)
    }
    numbers = {value.strip() for value in values}
    only = numbers.pop() if len(numbers) == 1 else b""
    return int(only) if re.fullmatch(rb"\d{1,5}", only) else None
