"""Values of annotations that are more than a number or a word: any text, bytes, steps of a collection."""

from __future__ import annotations

import mujoco
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simx_server.scene.formats.annotations import SceneError, parse, read_annotations
from simx_server.scene.formats.loader import load_text
from simx_server.scene.formats.texts.values import (
    block,
    decode,
    decode_bytes,
    encode,
    encode_bytes,
    encode_key,
    read_steps,
    steps,
    two_numbers,
    write_steps,
)

EMPTY = "<mujoco><custom>{}</custom></mujoco>"


@given(st.text())
def test_any_text_comes_back(text: str) -> None:
    assert decode(encode(text)) == text
    assert len(f"a {encode(text)} b".split()) == (3 if text else 2)


@given(st.text())
def test_any_key_comes_back_before_the_first_equals_sign(text: str) -> None:
    key, _, value = f"{encode_key(text)}=x=y".partition("=")
    assert (decode(key), value) == (text, "x=y")


@given(st.binary())
def test_any_bytes_come_back(data: bytes) -> None:
    assert decode_bytes(block(encode_bytes(data))) == data


@given(st.text(min_size=1), st.text())
def test_parameters_survive_a_file(key: str, value: str) -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_body(name="base").add_geom(size=[1, 0, 0])
    spec.add_text(name="simx:parameters:base", data=f"{encode_key(key)}={encode(value)}")
    found = read_annotations(mujoco.MjSpec.from_string(spec.to_xml()))
    assert found.objects["base"]["parameters"] == {key: value}


def test_a_percent_sign_without_digits_is_itself() -> None:
    assert parse("parameters", "share=50% rate=%zz", "x") == {"share": "50%", "rate": "%zz"}


def test_percent_signs_in_keys_and_values_mean_characters() -> None:
    assert parse("parameters", "max%20speed=1%2C5%20m/s", "x") == {"max speed": "1,5 m/s"}


@pytest.mark.parametrize("value", ["?", "abc", "A A="])
def test_wrong_bytes_name_the_element(value: str) -> None:
    with pytest.raises(SceneError, match=r"simx:data:base.*(?:bytes in base64|valid is key=value)"):
        parse("data", f"CONF={value}", "simx:data:base")


def test_a_long_wrong_value_is_not_repeated_in_the_message() -> None:
    with pytest.raises(SceneError) as problem:
        parse("data", f"CONF={'?' * 100_000}", "simx:data:base")
    assert len(str(problem.value)) < 500


def test_steps_are_read_in_their_order() -> None:
    text = "+all,-tree:robot,+object:wall,-above:a:b"
    found = [(False, "all", ""), (True, "tree", "robot"), (False, "object", "wall"), (True, "above", "a:b")]
    assert read_steps(steps(text)) == found
    assert write_steps(found) == text


@pytest.mark.parametrize("text", ["", "all", "*all", "+all:x", "+tree", "+tree:", "+what:x", "+all,"])
def test_wrong_steps_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="steps such as"):
        steps(text)


@pytest.mark.parametrize("text", ["", "1", "1,", "1,2,3", "a,b", "-1,2", "inf,1", "nan,1"])
def test_wrong_pairs_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="2 numbers not below 0"):
        two_numbers(text)


def test_settings_of_the_scene_have_one_name() -> None:
    with pytest.raises(SceneError, match="valid is 'simx:scene:world'"):
        load_text(EMPTY.format('<text name="simx:scene:other" data="engine=ode"/>'))
