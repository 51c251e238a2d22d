"""Check the words and constructions of pages, docstrings, comments, help texts and log lines.

Each finding is one line: file, line, the words found and what to write instead. Exit code 1: there are findings.
``python tests/system/english.py`` reads the pages and the folders in ``CLEAN``; with paths as arguments it reads those.
A folder joins ``CLEAN`` once it has no findings.
"""

from __future__ import annotations

import ast
import functools
import gc
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "docs/**/*.md")
GENERATED = {"api.md", "coverage.md", "pyrep-functions.md", "script-functions.md"}
"""Pages made from docstrings and tables in Python: a finding belongs to its source."""

CLEAN = ("simx_client", "simx_server", "tests")
"""Folders whose Python texts have no findings; of tests only docstrings are read. Only add to this list."""

PROGRAMS = ROOT / "tests" / "old_programs" / "programs"
"""Programs of others' form, some in Python 2: not read."""

PENDING: set[str] = set()
"""Files in clean folders that still have findings. Only remove from this list."""


@dataclass(frozen=True)
class Rule:
    """One expression that plain English avoids, and what to write instead."""

    expression: re.Pattern[str]
    instead: str


def rule(expression: str, instead: str, flags: int = re.IGNORECASE) -> Rule:
    """Return a rule; a space in the expression also matches the end of a line."""
    return Rule(re.compile(expression.replace(" ", r"\s+"), flags | re.MULTILINE), instead)


SENTENCE = r"(?:^|[.:;!?|(] |[.:;!?]\\* )"
RULES = (
    rule(
        SENTENCE + r"(?:What|Who|Whoever|Whatever) (?=\w)(?![^.]*\?)",
        "name the thing that acts; no headless relative clause",
        0,
    ),
    rule(r"\b(?:whoever|whomever)\b", "'a client that', 'the caller'"),
    rule(r"\bnobody\b", "a positive statement: 'no client', 'the server ... only'"),
    rule(r"\b(?:is|are|was|were) no \w+", "'is not a', 'has no'"),
    rule(r"\bwhose turn\b", "'the next client'"),
    rule(r"\bso many\b", "a number, 'this many', 'that number of'"),
    rule(r"\banew\b", "'again'"),
    rule(r"\bby (?:itself|themselves)\b", "'automatically', 'alone'"),
    rule(r"\bof (?:its|their|his|your|one's) own\b", "'its own X', 'a private X', 'a separate X'"),
    rule(r"\bof late\b", "'recently'"),
    rule(r"\bmend(?:s|ed|ing)?\b", "'fix'"),
    rule(r"\bbeg(?:in|ins|an|un|inning)\b", "'start'"),
    rule(r"\b(?:not|nothing) to be had\b", "'is not available', 'cannot be'"),
    rule(r"\bpatience\b", "'time-out'"),
    rule(r"\blinger(?:s|ed|ing)?\b", "'batch', 'coalesce'"),
    rule(r"\b(?:gives?|gave|giving) (?:up (?:no|on)|way)\b", "'drop', 'wait'"),
    rule(r"\blets? (?:nobody|somebody|everybody|it|them|him) in\b", "'accept'"),
    rule(r"\bpage in the browser\b|\bpage of (?:`)?--view\b", "'web viewer'"),
    rule(r"\b(?:server|simulation)(?:'s)? engine\b", "'server loop'"),
    rule(r"\b(?:camera|sensor|vision)(?:'s|s)? pictures?\b", "'image'"),
    rule(r"\blocal way\b", "'lane'"),
    rule(r"(?<!under\x20)\bways? in\b(?! (?:between|which|metres|a )\b)", "'gateway'"),
    rule(r"\bmap of the house\b|\bthe rooms\b", "'architecture', 'layout'"),
)

NOUN = re.compile(
    r"(?:A|An|The|All|Any|Each|Every|What|Whether|Which|Who|How|Where|When|Of|One|Two|Both|Per|As|For|From|In|On|At"
    r"|Seconds|Its|This|That|These|Those|It|If|Not|No|Nothing|Only|With|Without|Same|Like)\b"
)
"""Beginnings of a docstring that does not say in the imperative what the function does."""


def search(text: str, line: int) -> Iterator[tuple[int, str]]:
    """Yield line and finding of each rule that a text breaks; the text starts at the line given."""
    for each in RULES:
        for found in each.expression.finditer(text):
            at = line + text.count("\n", 0, found.start())
            yield at, f"'{' '.join(found[0].split())}': write {each.instead}"


def blank(found: re.Match[str]) -> str:
    """Return as many line ends as the match has, so that the lines after it keep their numbers."""
    return "\n" * found[0].count("\n")


def page_findings(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the findings in a Markdown page, its fenced blocks left out."""
    yield from search(re.sub(r"```.*?```", blank, path.read_text(encoding="utf-8"), flags=re.DOTALL), 1)


def is_log_call(node: ast.Call) -> bool:
    """Return whether a call writes a log line, as ``log.info(...)`` and ``LOG.warning(...)`` do."""
    function = node.func
    levels = {"debug", "info", "warning", "error", "exception", "critical"}
    return (
        isinstance(function, ast.Attribute)
        and function.attr in levels
        and isinstance(function.value, ast.Name)
        and "log" in function.value.id.lower()
    )


def strings(node: ast.expr | None) -> Iterator[tuple[str, int]]:
    """Yield the texts inside an expression with their lines; those of f-strings part by part."""
    for each in ast.walk(node) if node is not None else ():
        if isinstance(each, ast.Constant) and isinstance(each.value, str):
            yield each.value, each.lineno


def takers_of_help(nodes: Sequence[ast.AST]) -> Iterator[tuple[str, int]]:
    """Yield the functions of a module that have a parameter ``help``, and its position."""
    for node in nodes:
        if isinstance(node, ast.FunctionDef):
            names = [each.arg for each in node.args.args]
            if "help" in names:
                yield node.name, names.index("help")


def texts(nodes: Sequence[ast.AST]) -> Iterator[tuple[str, int]]:
    """Yield docstrings, help texts and log lines of a module with the lines where they start.

    Help texts are arguments named ``help``, also of a function of the module that takes such an argument by position.
    """
    helpers = dict(takers_of_help(nodes))
    for node in nodes:
        if isinstance(node, ast.Expr):
            yield from strings(node.value if isinstance(node.value, ast.Constant) else None)
        elif isinstance(node, ast.Call):
            for keyword in node.keywords:
                if keyword.arg in {"help", "description", "epilog", "doc"}:
                    yield from strings(keyword.value)
            at = helpers.get(getattr(node.func, "id", ""), len(node.args))
            for argument in node.args[at : at + 1]:
                yield from strings(argument)
            if is_log_call(node) and node.args:
                yield from strings(node.args[0])


STRING_OR_COMMENT = re.compile(
    r"""(?P<quotes>\"{3}|'{3}|["'])(?:\\.|.)*?(?P=quotes)|\#[ \#]*(?P<comment>[^\n]*)""", re.DOTALL
)
"""Tokens would take ten times as long."""


def comments(source: str) -> Iterator[tuple[str, int]]:
    """Yield the comments of a module with their lines; those of adjacent lines as one text."""
    block: list[str] = []
    line = last = 1
    read = 0
    for found in STRING_OR_COMMENT.finditer(source):
        if found["comment"] is None:
            continue
        line += source.count("\n", read, found.start())
        read = found.start()
        if block and line != last + 1:
            yield "\n".join(block), last - len(block) + 1
            block = []
        block.append(found["comment"])
        last = line
    if block:
        yield "\n".join(block), last - len(block) + 1


def moods(nodes: Sequence[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield the functions whose docstring does not start with a verb in the imperative."""
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node) or ""
            if NOUN.match(text):
                yield (
                    node.body[0].lineno,
                    f"'{text.split()[0]} ...': start with a verb: 'Return', 'Yield', 'Set'",
                )


WITHOUT_TEXTS = {"ctx", "op", "ops", "id", "attr", "arg", "kind", "module", "names", "type_comment"}
"""Fields of syntax trees that lead to no text: half of all nodes are in them."""


@functools.cache
def fields(kind: type[ast.AST]) -> tuple[str, ...]:
    """Return the fields of a kind of node that lead to texts."""
    return tuple(name for name in kind._fields if name not in WITHOUT_TEXTS)


def walk(tree: ast.AST) -> list[ast.AST]:
    """Return the nodes of a module that may have texts, in the order of `ast.walk`, which takes three times as long."""
    nodes = [tree]
    for node in nodes:
        for name in fields(type(node)):
            value = getattr(node, name, None)
            if isinstance(value, list):
                nodes += [each for each in value if isinstance(each, ast.AST)]
            elif isinstance(value, ast.AST):
                nodes.append(value)
    return [node for node in nodes if isinstance(node, SPEAKING)]


SPEAKING = (ast.Expr, ast.Call, ast.FunctionDef, ast.AsyncFunctionDef)


def findings_in(texts: Sequence[tuple[str, int]]) -> Iterator[tuple[int, str]]:
    """Yield the findings in texts with their lines, what is quoted as code left out."""
    read = [
        (re.sub(r"``.*?``", blank, text, flags=re.DOTALL) if "``" in text else text, line)
        for text, line in texts
    ]
    # All at once first: few files have findings, and they have many texts.
    together = "\n".join(text for text, _ in read)
    if any(each.expression.search(together) for each in RULES):
        for text, line in read:
            yield from search(text, line)


def module_findings(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the findings in the texts of a Python file."""
    source = path.read_text(encoding="utf-8")
    nodes = walk(ast.parse(source))
    yield from findings_in([*texts(nodes), *comments(source)])
    yield from moods(nodes)


def blocks(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield a module and its statements, also those inside others, without their expressions: a tenth of the nodes."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        yield (node := waiting.pop())
        inner = (ast.stmt, ast.excepthandler, ast.match_case)
        waiting += (child for child in ast.iter_child_nodes(node) if isinstance(child, inner))


def docstring_findings(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the findings in the docstrings of a test; they state facts, so the mood is free."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found: list[tuple[str, int]] = []
    for node in blocks(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node, clean=False) or ""
            if text:
                found.append((text, node.body[0].lineno))
    yield from findings_in(found)


def findings_of(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the findings in a page, a test or a module."""
    if path.suffix == ".md":
        return page_findings(path)
    is_test = path.is_relative_to(ROOT / "tests") and path != Path(__file__)
    return docstring_findings(path) if is_test else module_findings(path)


def chosen(arguments: Sequence[str]) -> Iterator[Path]:
    """Yield the files to read: those given, or the pages and the clean folders."""
    for pattern in () if arguments else PAGES:
        yield from (path for path in sorted(ROOT.glob(pattern)) if path.name not in GENERATED)
    for name in arguments or CLEAN:
        path = ROOT / name
        found = sorted(path.rglob("*.py")) if path.is_dir() else [path]
        found = [each for each in found if not each.is_relative_to(PROGRAMS)]
        yield from (each for each in found if arguments or str(each.relative_to(ROOT)) not in PENDING)


def main(arguments: list[str]) -> int:
    """Print each finding and how many there are; return the exit code."""
    files = list(chosen(arguments))
    count = 0
    gc.disable()  # it would search the syntax trees again and again, which takes longer than all else
    try:
        for path in files:
            for line, text in sorted(findings_of(path)):
                print(f"{path.relative_to(ROOT)}:{line}: {text}")
                count += 1
    finally:
        gc.enable()
    print(f"{len(files)} files read, {count} findings")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
