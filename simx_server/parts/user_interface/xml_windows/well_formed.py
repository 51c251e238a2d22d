"""XML as V-REP's windows accept it, which is less strict than the standard.

``<button text="<<"/>``, ``R & D``, an attribute twice, and characters that XML forbids: V-REP's parser (TinyXML-2)
reads all of them.
"""

from __future__ import annotations

import re

_NOT_XML = re.compile(r"[^\t\n\r\x20-\uD7FF\uE000-\uFFFD\U00010000-\U0010FFFF]")

# Each piece is read once, whatever is missing at its end: a window's text comes from scripts and files of strangers.
_PIECE = re.compile(
    r"""(?P<verbatim><!--(?:.*?-->|.*+)|<!\[CDATA\[(?:.*?\]\]>|.*+))"""
    r"""|(?P<declaration><\?(?:.*?\?>|(?P<open>.*+))|<!(?:[^>]*+>|(?P<open_too>.*+)))"""
    r"""|(?P<start><[A-Za-z_][^\s<>"'/=]*+)(?P<attributes>(?:[^<>"']|"[^"]*+"|'[^']*+')*+)>"""
    r"""|(?P<text>[^<]++)""",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(r"""(?P<name>[^\s"'=/]++)(?:\s*+=\s*+(?P<value>"[^"]*+"|'[^']*+'))?+""")
_BARE_AMPERSAND = re.compile(r"&(?!(?:#\d+|#x[0-9A-Fa-f]+|lt|gt|amp|quot|apos);)")


def well_formed(text: str) -> str:
    """Return a window's text as XML of the standard, without declarations; what cannot be fixed stays as it is."""
    return _PIECE.sub(_fixed, _NOT_XML.sub("", text)).strip()


def _fixed(found: re.Match[str]) -> str:
    if (words := found["text"]) is not None:
        return _escaped(words)
    if found["declaration"] is not None:
        has_end = found["open"] is None and found["open_too"] is None
        return "" if has_end else found[0]
    if found["verbatim"] is not None:
        return found[0]
    seen: set[str] = set()

    def once(attribute: re.Match[str]) -> str:
        name, value = attribute["name"], attribute["value"]
        if value is None:
            return name
        if name in seen:
            return ""
        seen.add(name)
        return f"{name}={_escaped(value)}"

    return f"{found['start']}{_ATTRIBUTE.sub(once, found['attributes'])}>"


def _escaped(words: str) -> str:
    return _BARE_AMPERSAND.sub("&amp;", words).replace("<", "&lt;")
