"""Tests of the check of words and constructions that `make check` runs."""

from __future__ import annotations

from pathlib import Path

import english
import pytest


def of_page(folder: Path, text: str) -> list[tuple[int, str]]:
    """Return the findings in a page with this text."""
    page = folder / "page.md"
    page.write_text(text, encoding="utf-8")
    return list(english.page_findings(page))


def of_module(folder: Path, text: str) -> list[tuple[int, str]]:
    """Return the findings in a Python file with this text."""
    module = folder / "module.py"
    module.write_text(text, encoding="utf-8")
    return sorted(english.module_findings(module))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("What lies still costs nothing.", "What"),
        ("It waits. Whoever steps is first.", "Whoever"),
        ("The server answers\nnobody meanwhile.", "nobody"),
        ("An id is no\nhandle.", "is no handle"),
        ("It compiles anew.", "anew"),
        ("Each has a queue of its\nown.", "of its own"),
        ("It starts by itself.", "by itself"),
        ("The patience of a call.", "patience"),
        ("| x | What it is. |", "| What"),
    ],
)
def test_odd_english_is_found_with_its_replacement(tmp_path: Path, text: str, words: str) -> None:
    (_, finding), *_ = of_page(tmp_path, f"# Title\n\n{text}\n")
    assert finding.startswith(f"'{words}") or f" {words}" in finding.partition("': write ")[0]
    assert ": write " in finding


@pytest.mark.parametrize(
    "text",
    [
        "What is a realm? Who may read?",
        "It prints what is missing.",
        "```\nWhat is here is code, anew\n```",
        "The parts own their data, and no client waits.",
    ],
)
def test_plain_english_and_code_are_left_alone(tmp_path: Path, text: str) -> None:
    assert of_page(tmp_path, text) == []


def test_docstrings_comments_helps_and_logs_of_python_are_read(tmp_path: Path) -> None:
    source = '''"""It is read anew."""
log.info("made anew")
add("--flag", help="made anew")  # built anew
text = "anew"
raise ValueError("anew")
'''
    assert [line for line, _ in of_module(tmp_path, source)] == [1, 2, 3, 3]


def test_docstring_of_a_function_starts_with_a_verb(tmp_path: Path) -> None:
    source = 'def right() -> None:\n    """Return it."""\n\ndef wrong() -> None:\n    """The result."""\n'
    assert [line for line, _ in of_module(tmp_path, source)] == [5]


def test_pages_and_clean_folders_have_no_findings(capsys: pytest.CaptureFixture[str]) -> None:
    assert english.main([]) == 0, capsys.readouterr().out


def test_help_that_is_passed_by_position_is_read(tmp_path: Path) -> None:
    module = 'def _setting(default, help): ...\n\n\nx = _setting(1, "so many servers")\n'
    assert [line for line, _ in of_module(tmp_path, module)] == [4]


def test_docstrings_of_tests_are_read_and_may_state_facts(tmp_path: Path) -> None:
    test = tmp_path / "test_it.py"
    test.write_text('"""Who waits, waits."""\n\n\ndef test_it():\n    """A fact."""\n', encoding="utf-8")
    assert [line for line, _ in english.docstring_findings(test)] == [1]
