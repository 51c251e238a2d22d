"""An object changes its own attributes; code of other folders calls its methods."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest
from statements import parsed, statements

from simx_client.protocol.python.garbage import no_collections

ROOT = Path(__file__).parents[2]
PRODUCT = ("simx_server", "simx_client")
RECORDS = {"NamedTuple", "Protocol", "TypedDict"}


def files() -> dict[Path, ast.Module]:
    return {path: parsed(path) for folder in PRODUCT for path in sorted((ROOT / folder).rglob("*.py"))}


def assigned(tree: ast.AST) -> Iterator[ast.Attribute]:
    """Every attribute that a statement assigns, also as one of several."""
    for statement in statements(tree):
        for target in targets(statement):
            for node in ast.walk(target):
                if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                    yield node


def targets(statement: ast.AST) -> list[ast.expr]:
    """Return the targets of a statement: `=`, `+=`, with an annotation, `for`, `with`."""
    if isinstance(statement, ast.Assign):
        return statement.targets
    if isinstance(statement, ast.With | ast.AsyncWith):
        return [each.optional_vars for each in statement.items if each.optional_vars is not None]
    target = getattr(statement, "target", None)
    return [] if target is None else [target]


def is_own(attribute: ast.Attribute) -> bool:
    return isinstance(attribute.value, ast.Name) and attribute.value.id in ("self", "cls")


def is_record(definition: ast.ClassDef) -> bool:
    bases = {ast.unparse(base).rpartition(".")[2] for base in definition.bases}
    return bool(bases & RECORDS) or any(
        "dataclass" in ast.unparse(each) for each in definition.decorator_list
    )


def declared(definition: ast.ClassDef) -> set[str]:
    """The names of a class's attributes."""
    names = {each.attr for each in assigned(definition) if is_own(each)}
    for each in definition.body:
        targets = each.targets if isinstance(each, ast.Assign) else [getattr(each, "target", None)]
        names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names


def from_outside(trees: dict[Path, ast.Module]) -> list[str]:
    """Assignments to attributes of classes that are neither records nor MuJoCo's, from other folders than theirs.

    A class is found by the name of the attribute; a name that a record has too is passed over.
    """
    folders: defaultdict[str, set[Path]] = defaultdict(set)
    plain = {name for kind in vars(mujoco).values() if isinstance(kind, type) for name in dir(kind)}
    for path, tree in trees.items():
        for definition in statements(tree):
            if isinstance(definition, ast.ClassDef):
                if is_record(definition):
                    plain |= declared(definition)
                else:
                    for name in declared(definition):
                        folders[name].add(path.parent)
    known = folders.keys() - plain
    return [
        f"{path}:{each.lineno}: {ast.unparse(each)}"
        for path, tree in trees.items()
        for each in assigned(tree)
        if not is_own(each) and each.attr in known and not folders[each.attr] & {*path.parents}
    ]


def test_no_attribute_is_assigned_from_another_folder() -> None:
    with no_collections():  # they would search all these trees again and again
        assert from_outside(files()) == []


@pytest.mark.parametrize(
    "statement",
    [
        "part.state = 1",
        "part.state += 1",
        "part.other, part.state = 1, 2",
        "part.state: int = 1",
        "for part.state in range(2):\n    pass",
        "with open('it') as part.state:\n    pass",
    ],
)
def test_an_assignment_from_another_folder_is_found(statement: str) -> None:
    here, there = Path("a/part.py"), Path("b/user.py")
    part = ast.parse("class Part:\n    def __init__(self):\n        self.state = 0")
    assert from_outside({here: part, there: ast.parse(statement)}) == ["b/user.py:1: part.state"]
    assert from_outside({here: part, Path("a/c/user.py"): ast.parse(statement)}) == []
