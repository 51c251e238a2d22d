"""Results of scripts: values that no client can receive are refused with a sentence, and the script lives on."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from fuzz.attacks import bounded
from fuzz.results import SAFE, Scripts, result_of
from hypothesis import given
from hypothesis import strategies as st
from seeds import many

import simx_client as v

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scripts]:
    each = Scripts(tmp_path_factory.mktemp("scripts"))
    yield each
    each.close()


@pytest.mark.parametrize("language", ["lua", "python"])
def test_no_result_of_a_script_is_more_than_an_error(scripts: Scripts, language: str) -> None:
    @bounded(many(60), derandomize=True)
    @given(st.data())
    def attack(data: st.DataObject) -> None:
        scripts.endure(language, data.draw(result_of(language)))

    attack()
    assert scripts.endure(language, ", ".join(SAFE[language])) == v.simx_return_ok


@pytest.mark.parametrize("bad", ["10**400", "10**5000", "'\\ud800'"])
def test_numbers_and_texts_that_only_python_has_are_refused_with_a_sentence(
    scripts: Scripts, bad: str
) -> None:
    for results in (
        f"[{bad}], [{bad}], [], ''",
        f"[], [{bad}], [], ''",
        f"[], [], [{bad}], ''",
        f"[], [], [], {bad}",
    ):
        scripts.endure("python", results)
