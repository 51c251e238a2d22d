"""The use of API 2, CoppeliaSim 4.11's object model, whose package has the name of a legacy binding: `sim`."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from .places import Place
from .program import Program, Source, imported

PACKAGE = "sim"

NAMES = ("IK", "Object", "ObjectArray", "Path", "PropertyGroup", "app", "const", "scene", "self")
"""Members of the package that no legacy binding has: names there start with simx or sim_."""


def model_calls(program: Program) -> dict[str, Place]:
    """Return what a program uses of API 2, such as ``sim.scene.getObject``, and where first; none: another API.

    The names behind a variable, as of ``scene`` in ``scene = sim.scene``, are not known.
    """
    found: dict[str, Place] = {}
    for source in program.sources:
        for name, line in _of_source(source):
            found.setdefault(name, Place(source.path, line))
    return found


def _of_source(source: Source) -> Iterator[tuple[str, int]]:
    modules: set[str] = set()
    members: dict[str, str] = {}
    for each in imported(source):
        if each.level:
            continue
        if each.module.startswith(f"{PACKAGE}."):
            yield each.module, each.line
        elif each.module == PACKAGE:
            yield from ((f"{PACKAGE}.{name}", each.line) for name in each.names if name in NAMES)
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Import):
            modules |= {alias.asname or alias.name for alias in node.names if alias.name == PACKAGE}
        elif isinstance(node, ast.ImportFrom) and node.module == PACKAGE and not node.level:
            members |= {alias.asname or alias.name: alias.name for alias in node.names if alias.name in NAMES}
    for node in _whole_chains(source.tree):
        chain = _chain(node)
        if chain and chain[0] in modules and len(chain) > 1 and chain[1] in NAMES:
            yield ".".join((PACKAGE, *chain[1:])), node.lineno
        elif chain and chain[0] in members:
            yield ".".join((PACKAGE, members[chain[0]], *chain[1:])), node.lineno


def _whole_chains(tree: ast.Module) -> Iterator[ast.Attribute]:
    """Yield ``sim.scene.simulation.start``, and not ``sim.scene`` within it."""
    found = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    within = {id(node.value) for node in found}
    yield from (node for node in found if id(node) not in within)


def _chain(node: ast.Attribute) -> list[str]:
    """Return the names of ``sim.scene.simulation.start``; none where something else than a name is in front."""
    names: list[str] = []
    part: ast.expr = node
    while isinstance(part, ast.Attribute):
        names.append(part.attr)
        part = part.value
    return [part.id, *reversed(names)] if isinstance(part, ast.Name) and names else []
