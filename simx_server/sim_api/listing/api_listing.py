"""Names and descriptions of the API, for programs that complete or explain code."""

from __future__ import annotations

from simx_server.sim_api.base import ApiPart

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
        found = {
            name: info for name, info in self._world.scripts.describe_api().items() if name.startswith(start)
        }
        if word.startswith((_FUNCTIONS_ONLY, _CONSTANTS_ONLY)):
            wants_functions = word.startswith(_FUNCTIONS_ONLY)
            found = {name: info for name, info in found.items() if ("(" in info) == wants_functions}
        if start and "." not in start:
            return sorted({name.partition(".")[0] for name in found})
        return sorted(found)

    def getApiInfo(self, _script: int, name: str) -> str | None:
        """Return the arguments of a function and what it does, or the value of a constant; nil for another name."""
        return self._world.scripts.describe_api().get(name)
