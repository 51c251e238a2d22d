"""Values of annotations that need more than a number or a word: any text, bytes, and lists.

In a value, and in a key that may be anything, `%20` is a space: `%` and two hexadecimal digits stand for a byte of
UTF-8, as in addresses of the web. A `%` without two such digits is itself.
"""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Callable
from urllib.parse import unquote

_UNSAFE = re.compile(r"[\x00-\x20\x7f-\xa0\u1680\u2000-\u200a\u2028\u2029\u202f\u205f\u3000\ud800-\udfff%]")
"""What `encode` replaces: white space, which ends a word, what XML cannot hold, and `%`."""

STEPS = ("object", "tree", "below", "chain", "above")
"""Kinds of steps of a collection that name an object; `all` names none."""


def encode(text: str) -> str:
    """Return a text in the form in which an annotation can hold it; `decode` gives it back."""
    return _UNSAFE.sub(lambda found: _escaped(found[0]), text)


def encode_key(text: str) -> str:
    """Return a key in the form in which an annotation can hold it."""
    return encode(text).replace("=", "%3D")


def decode(text: str) -> str:
    """Return the text that a value, or a key, of an annotation means."""
    return unquote(text, errors="surrogateescape") if "%" in text else text


def encode_bytes(data: bytes) -> str:
    """Return bytes in the form in which an annotation can hold them (base64)."""
    return base64.b64encode(data).decode("ascii")


def decode_bytes(text: str) -> bytes:
    """Return the bytes of a checked value."""
    return base64.b64decode(text)


def block(text: str) -> str:
    """Check bytes in base64. Raises ValueError with what is valid."""
    try:
        base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise ValueError("bytes in base64") from None
    return text


def each(check: Callable[[str], object]) -> Callable[[str], str]:
    """Return the check of one value, or of several with semicolons between them."""

    def checked(text: str) -> str:
        for word in text.split(";"):
            try:
                check(word)
            except ValueError as error:
                raise ValueError(
                    f"{error}; one value, or one for each tip with semicolons between them"
                ) from None
        return text

    return checked


def two_numbers(text: str) -> str:
    """Check two numbers not below 0. Raises ValueError with what is valid."""
    words = text.split(",")
    try:
        is_valid = len(words) == 2 and all(0 <= float(word) < float("inf") for word in words)
    except ValueError:
        is_valid = False
    if not is_valid:
        raise ValueError("2 numbers not below 0 with a comma between them")
    return text


def steps(text: str) -> str:
    """Check the steps of a collection. Raises ValueError with what is valid."""
    for word in text.split(","):
        sign, (kind, colon, name) = word[:1], word[1:].partition(":")
        named = kind in STEPS and bool(colon) and bool(name)
        if sign not in ("+", "-") or not (named or (kind == "all" and not colon)):
            raise ValueError("steps such as +all,-tree:robot,+object:wall")
    return text


def read_steps(text: str) -> list[tuple[bool, str, str]]:
    """Return the steps of a checked value: whether objects are taken out, kind, name of the object ('' for all)."""
    found: list[tuple[bool, str, str]] = []
    for word in text.split(",") if text else ():
        kind, _, name = word[1:].partition(":")
        found.append((word[0] == "-", kind, name))
    return found


def write_steps(listed: list[tuple[bool, str, str]]) -> str:
    """Return the value that `read_steps` reads."""
    return ",".join(f"{'-' if out else '+'}{kind}{':' if name else ''}{name}" for out, kind, name in listed)


def _escaped(character: str) -> str:
    return "".join(f"%{byte:02X}" for byte in character.encode("utf-8", "surrogateescape"))
