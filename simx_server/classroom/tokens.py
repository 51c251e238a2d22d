"""Tokens of a class: one for the teacher, one for each seat. A file keeps them, so that links stay valid.

The file is JSON and readable by its owner only. Seats that it lacks get a new token, which is added to it.
"""

from __future__ import annotations

import json
import os
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

TOKEN_BYTES = 16
"""Random bytes of a token; 22 characters."""

MOST_BYTES = 1 << 20
"""Maximum size of a file of tokens."""

_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,64}")
_FORM = (
    '{"teacher": TOKEN, "seats": {"1": TOKEN, ...}}, where a TOKEN has 16 to 64 letters, digits, "-" and "_"'
)


class TokensError(ValueError):
    """A file of tokens cannot be used; the text has the reason and the next step."""


@dataclass(frozen=True)
class Tokens:
    """All tokens of a class."""

    teacher: str
    seats: Mapping[int, str]
    """By the number of the seat, from 1."""


def make_tokens(seats: int, file: Path | None = None) -> Tokens:
    """Return the tokens of a class with this many seats.

    Args:
        file: keeps the tokens; a new one is made, an existing one is read and completed.

    Raises:
        TokensError: the file cannot be read or written, or it has another form.
    """
    kept = _read(file) if file is not None and file.exists() else Tokens("", {})
    tokens = Tokens(
        kept.teacher or _new(),
        {**kept.seats, **{seat: _new() for seat in range(1, seats + 1) if seat not in kept.seats}},
    )
    if len({tokens.teacher, *tokens.seats.values()}) <= len(tokens.seats):
        raise TokensError(
            f"'{file}' has the same token twice, so a seat could not be told from another; delete one of both lines"
        )
    if file is not None and tokens != kept:
        _write(file, tokens)
    return tokens


def _new() -> str:
    return secrets.token_urlsafe(TOKEN_BYTES)


def _read(file: Path) -> Tokens:
    try:
        if os.name == "posix" and file.stat().st_mode & 0o077:
            raise TokensError(f"other users of this machine can read '{file}'; run: chmod 600 '{file}'")
        if file.stat().st_size > MOST_BYTES:
            raise TokensError(f"'{file}' is too large for a file of tokens: more than {MOST_BYTES} bytes")
        content = json.loads(file.read_text(encoding="utf-8"))
        teacher, seats = _token(content["teacher"]), cast(dict[str, Any], content["seats"])
        return Tokens(teacher, {_seat(name): _token(token) for name, token in seats.items()})
    except OSError as error:
        raise TokensError(f"'{file}' cannot be read: {error.strerror}") from None
    except TokensError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise TokensError(
            f"'{file}' is not a file of tokens; valid: {_FORM}; or name a file that does not exist yet"
        ) from None


def _seat(name: str) -> int:
    if not re.fullmatch(r"[1-9][0-9]{0,3}", name):
        raise ValueError(name)
    return int(name)


def _token(text: object) -> str:
    if not isinstance(text, str) or not _TOKEN.fullmatch(text):
        raise ValueError(text)
    return text


def _write(file: Path, tokens: Tokens) -> None:
    """Replace the file in one step: a full disk must not cost the tokens."""
    text = json.dumps({"teacher": tokens.teacher, "seats": dict(sorted(tokens.seats.items()))}, indent=1)
    new = file.with_name(f"{file.name}.{os.getpid()}.new")
    try:
        descriptor = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            with open(descriptor, "w", encoding="utf-8") as stream:
                stream.write(text + "\n")
            os.replace(new, file)
        finally:
            new.unlink(missing_ok=True)
    except OSError as error:
        raise TokensError(
            f"'{file}' cannot be written: {error.strerror}; name a file in a folder of yours"
        ) from None
