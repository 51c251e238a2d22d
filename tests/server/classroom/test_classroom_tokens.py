"""Tokens of a class: new ones, those that a file keeps, and files that cannot be used."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from simx_server.classroom.tokens import TokensError, make_tokens

pytestmark = pytest.mark.slow

TOKEN = "abcdefghijklmnop"


def keep(file: Path, text: str) -> Path:
    file.write_text(text)
    file.chmod(0o600)
    return file


def test_each_seat_and_the_teacher_have_a_token_that_no_other_has() -> None:
    tokens = make_tokens(30)
    assert sorted(tokens.seats) == list(range(1, 31))
    everything = [tokens.teacher, *tokens.seats.values()]
    assert len(set(everything)) == 31
    assert all(len(token) >= 22 for token in everything)
    assert make_tokens(30) != tokens


def test_file_keeps_tokens_and_gets_those_of_further_seats(tmp_path: Path) -> None:
    file = tmp_path / "tokens.json"
    first = make_tokens(2, file)
    assert file.stat().st_mode & 0o777 == 0o600
    assert make_tokens(2, file) == first
    more = make_tokens(4, file)
    assert {**more.seats, **first.seats} == more.seats
    assert more.teacher == first.teacher
    assert make_tokens(1, file).seats == more.seats  # seats that are not used keep theirs
    assert os.listdir(tmp_path) == ["tokens.json"]


def test_file_that_others_can_read_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "tokens.json"
    make_tokens(2, file)
    file.chmod(0o640)
    with pytest.raises(TokensError, match="chmod 600"):
        make_tokens(2, file)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"teacher": 1, "seats": {}}',
        '{"teacher": "short", "seats": {}}',
        json.dumps({"teacher": TOKEN, "seats": [TOKEN]}),
        json.dumps({"teacher": TOKEN, "seats": {"0": TOKEN}}),
        json.dumps({"teacher": TOKEN, "seats": {"1": "with:colon:in:the:middle"}}),
        json.dumps({"teacher": TOKEN, "seats": {"1": TOKEN + "\nother:password"}}),
        "[" * 100_000,
    ],
)
def test_file_of_another_form_is_refused_and_kept(tmp_path: Path, text: str) -> None:
    file = keep(tmp_path / "tokens.json", text)
    with pytest.raises(TokensError, match="not a file of tokens"):
        make_tokens(2, file)
    assert file.read_text() == text


def test_token_that_two_seats_share_is_refused(tmp_path: Path) -> None:
    seats = {"1": TOKEN, "2": TOKEN}
    file = keep(tmp_path / "tokens.json", json.dumps({"teacher": TOKEN[::-1], "seats": seats}))
    with pytest.raises(TokensError, match="the same token twice"):
        make_tokens(2, file)
