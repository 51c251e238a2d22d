"""JSON texts from outside."""

from __future__ import annotations

import json

import pytest

from simx_server.scene.formats.texts.json_text import MOST_NESTED, load_json


@pytest.mark.parametrize(
    "text",
    ['{"a": [1, {"b": "]}[{"}]}', r'{"quote": "\"[\\"}', '"[[["', "[" * MOST_NESTED + "]" * MOST_NESTED],
)
def test_a_text_is_read_as_json_reads_it(text: str) -> None:
    assert load_json(text) == json.loads(text)


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, '{"a":' * 100_000, "[" * (MOST_NESTED + 1) + "]" * (MOST_NESTED + 1)],
    ids=["lists", "objects", "closed"],
)
def test_a_text_that_is_nested_deeply_is_not_parsed(text: str) -> None:
    with pytest.raises(ValueError, match="nested more than 64 levels deep"):
        load_json(text)


@pytest.mark.parametrize(
    "text",
    ["", "[", '"' * 100_001, r'"\"' * 100_000, "nonsense"],
    ids=["empty", "open", "quotes", "escapes", "words"],
)
def test_what_is_not_json_is_an_error(text: str) -> None:
    with pytest.raises(json.JSONDecodeError):
        load_json(text)
