"""Strings of the server in languages that tell text from bytes: the scripts' own hold either."""

from __future__ import annotations

import re
from typing import Any

from ..interpreter import Plain

GIVES_BYTES = re.compile(r"\.pack|Buffer|Img|Image|Depth|CustomDataBlock$|persistentDataRead")
"""Functions whose results are bytes even when these could be text."""

GIVES_TEXT = re.compile(
    r"\.(getStringSignal|readCustomStringData|getExtensionString|getSettingString|getScriptText|receiveData)$"
)
"""Functions whose results are text where they can be, although they hold any bytes."""

LONG_LIST = 16
"""Items above which a list is looked at as a whole first."""

NUMBERS = {int, float, bool, type(None)}
"""Types that contain no strings."""

_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")


def with_texts(value: Plain, *, as_bytes: bool = False) -> Any:
    """Return a value with text (UTF-8 without control characters) as str, and other strings as bytes.

    Args:
        as_bytes: every string is bytes; keys are text all the same.
    """
    if isinstance(value, bytes):
        if as_bytes:
            return value
        try:
            text = value.decode()
        except UnicodeDecodeError:
            return value
        return value if _CONTROL.search(text) else text
    if isinstance(value, (list, tuple)):
        if len(value) > LONG_LIST and set(map(type, value)) <= NUMBERS:
            return value
        return [with_texts(item, as_bytes=as_bytes) for item in value]
    if isinstance(value, dict):
        return {with_texts(key): with_texts(item, as_bytes=as_bytes) for key, item in value.items()}
    return value
