"""XML as V-REP's windows accept it, which is less strict than the standard.

``<button text="<<"/>``, ``R & D``, an attribute twice, and characters that XML forbids: V-REP's parser (TinyXML-2)
reads all of them.
"""

from __future__ import annotations

import re

_DECLARATION = re.compile(r"<!(?!--|\[CDATA\[)[^>]*>|<\?.*?\?>", re.DOTALL)
_NOT_XML = re.compile(r"[^\t\n\r\x20-\uD7FF\uE000-\uFFFD\U00010000-\U0010FFFF]")
_VERBATIM_OR_TAG = re.compile(
    r"""<!--.*?-->|<!\[CDATA\[.*?\]\]>|(?P<start><[A-Za-z_][^\s<>"'/=]*)(?P<attributes>(?:[^<>"']|"[^"]*"|'[^']*')*)>"""
    r"""|(?P<text>[^<]+)""",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(r"""(?P<name>[^\s"'=/]+)\s*=\s*(?P<value>"[^"]*"|'[^']*')""")
_BARE_AMPERSAND = re.compile(r"&(?!(?:#\d+|#x[0-9A-Fa-f]+|lt|gt|amp|quot|apos);)")


def well_formed(text: str) -> str:
    """Return a window's text as XML of the standard, without declarations; what cannot be fixed stays as it is."""
    text = _DECLARATION.sub("", _NOT_XML.sub("", text))
    return _VERBATIM_OR_TAG.sub(_fixed, text).strip()


def _fixed(found: re.Match[str]) -> str:
    if (words := found["text"]) is not None:
        return _escaped(words)
    if found["start"] is None:
        return found[0]
    seen: set[str] = set()

    def once(attribute: re.Match[str]) -> str:
        name = attribute["name"]
        if name in seen:
            return ""
        seen.add(name)
        return f"{name}={_escaped(attribute['value'])}"

    return f"{found['start']}{_ATTRIBUTE.sub(once, found['attributes'])}>"


def _escaped(words: str) -> str:
    return _BARE_AMPERSAND.sub("&amp;", words).replace("<", "&lt;")
