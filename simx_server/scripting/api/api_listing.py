"""Names and descriptions of the API, for programs that complete or explain code."""

from __future__ import annotations

from functools import cache

from simx_server.scripting.api.base import ApiPart

_FUNCTIONS_ONLY, _CONSTANTS_ONLY = "+", "-"
"""Prefixes of the word to complete."""


class ApiListingFunctions(ApiPart):
    """Functions that list the API itself."""

    def getApiFunc(self, _script: int, word: str) -> list[str]:
        """Return the names of functions and constants that start with a word, such as `sim.getObj`, in alphabetical
        order; without a dot in the word only namespaces, with an empty word all names. A `+` in front of the word
        leaves out constants, a `-` functions.
        """
        start = word.removeprefix(_FUNCTIONS_ONLY).removeprefix(_CONSTANTS_ONLY)
        found = {name: info for name, info in _known().items() if name.startswith(start)}
        if word.startswith((_FUNCTIONS_ONLY, _CONSTANTS_ONLY)):
            wants_functions = word.startswith(_FUNCTIONS_ONLY)
            found = {name: info for name, info in found.items() if ("(" in info) == wants_functions}
        if start and "." not in start:
            return sorted({name.partition(".")[0] for name in found})
        return sorted(found)

    def getApiInfo(self, _script: int, name: str) -> str | None:
        """Return the arguments of a function and what it does, or the value of a constant; nil for another name."""
        return _known().get(name)


@cache
def _known() -> dict[str, str]:
    """Return all functions and constants by full name, each with its description.

    The import is delayed: the listing is made from all parts of the API, of which this is one.
    """
    from simx_server.scripting.coverage import script_functions
    from simx_server.scripting.namespaces import Namespaces

    found = {
        f"{space}.{name}": f"{space}.{name} = {value}"
        for space, members in Namespaces.names().items()
        for name, value in members.items()
        if value is not None
    }
    for line in script_functions():
        tip = f"{line.name}({line.arguments})"
        found[line.name] = "\n".join(text for text in (tip, line.doc, line.differs) if text)
    return found
