"""Messages survive the way; anything else is refused with one kind of error."""

import contextlib
import math
import struct

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from seeds import many

from simx_client.protocol import kinds
from simx_client.protocol.codec import (
    CodecError,
    NumberPacker,
    decode_batch,
    decode_delivery,
    decode_greeting,
    decode_welcome,
    encode,
    encode_delivery,
    pack_answer,
    pack_reply_head,
)
from simx_client.protocol.messages import Batch, Call, Delivery, Greeting, Reply, Welcome

pytestmark = pytest.mark.slow

int32 = st.integers(-(2**31), 2**31 - 1)
float32 = st.floats(width=32, allow_nan=False, allow_infinity=False)
values = st.recursive(
    st.one_of(int32, float32, st.booleans(), st.text(), st.binary(), st.none()), st.lists, max_leaves=8
)


def some(elements: st.SearchStrategy) -> st.SearchStrategy[list]:
    """Short lists: most of the time goes into drawing them, and long ones are tried by the number below."""
    return st.lists(elements, max_size=4)


@settings(max_examples=many(34))
@given(int32, int32, some(st.builds(Call, int32, int32, int32, st.text(), some(values))))
def test_a_batch_comes_back_as_it_was_sent(message_id, client_time, calls):
    batch = Batch(message_id, client_time, calls)
    assert decode_batch(encode(batch)) == batch


@settings(max_examples=many(34))
@given(int32, some(st.builds(Reply, int32, int32, int32, some(values))))
def test_a_delivery_comes_back_as_it_was_sent(number, replies):
    delivery = Delivery(number, number, number, number, 1, replies)
    assert decode_delivery(encode(delivery)) == delivery


@settings(max_examples=many(34))
@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_a_codec_error(payload):
    for decode in (decode_batch, decode_delivery, decode_greeting, decode_welcome):
        with contextlib.suppress(CodecError):
            decode(payload)


@settings(max_examples=many(34))
@given(values)
def test_any_msgpack_value_is_a_message_or_a_codec_error(value):
    for decode in (decode_batch, decode_delivery, decode_greeting, decode_welcome):
        with contextlib.suppress(CodecError):
            decode(msgpack.packb(value))


def test_numbers_travel_in_single_precision():
    reply = Reply(1, 0, 0, [0.1])
    came = decode_delivery(encode(Delivery(0, 0, 0, 0, 0, [reply])))
    assert came.replies[0].values == [struct.unpack("<f", struct.pack("<f", 0.1))[0]]


def test_a_newer_peer_may_say_more_in_its_greeting():
    longer = msgpack.packb([1, "abc", "prog", 19997, 3, "something new"])
    assert decode_greeting(longer) == Greeting(1, "abc", "prog", 19997, 3)
    longer = msgpack.packb([1, "", "realm", "scene", "0.1", "offer", {"new": 1}])
    assert decode_welcome(longer) == Welcome(1, "", "realm", "scene", "0.1", "offer")


def test_an_older_server_offers_no_socket():
    shorter = msgpack.packb([1, "", "realm", "scene", "0.1"])
    assert decode_welcome(shorter) == Welcome(1, "", "realm", "scene", "0.1", "")


@settings(max_examples=many(34))
@given(st.integers())
def test_integers_wrap_like_a_c_int(value):
    assert kinds.to_int32(value) == struct.unpack("<i", struct.pack("<I", value & 0xFFFF_FFFF))[0]


def test_arguments_of_old_scripts_are_accepted():
    np = pytest.importorskip("numpy")
    assert kinds.to_int32(np.array([7])) == 7
    assert type(kinds.to_int32(np.int64(7))) is int
    assert kinds.to_int32(True) == 1
    assert kinds.to_float(np.array([[0.5]])) == 0.5
    assert kinds.VECTOR3.coerce((1, 2)) == [1.0, 2.0, 0.0]
    assert kinds.VECTOR3.coerce(np.array([1, 2, 3])) == [1.0, 2.0, 3.0]
    assert kinds.to_text(b"Cuboid\0rest") == "Cuboid"
    assert kinds.to_pixels([-1, 0, 255]) == bytes([255, 0, 255])
    assert kinds.to_bytes("abc") == kinds.to_bytes(bytearray(b"abc")) == b"abc"


@pytest.mark.parametrize(
    ("coerce", "value", "error"),
    [
        (kinds.to_int32, 1.5, TypeError),
        (kinds.to_int32, "1", TypeError),
        (kinds.to_float, "x", TypeError),
        (kinds.VECTOR3.coerce, [1, 2, 3, 4], IndexError),
        (kinds.to_text, 3, TypeError),
        (kinds.to_texts, "abc", TypeError),
        (kinds.to_ints, 3, TypeError),
        (kinds.to_pixels, 3.5, TypeError),
    ],
)
def test_wrong_arguments_are_errors_that_say_what_was_given(coerce, value, error):
    with pytest.raises(error, match="needs"):
        coerce(value)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (kinds.INT, 2**40),
        (kinds.INT, True),
        (kinds.FLOAT, float("nan")),
        (kinds.FLOAT, float("inf")),
        (kinds.FLOAT, 1e300),
        (kinds.TEXT, 5),
        (kinds.BYTES, "text"),
        (kinds.INTS, [1, "2"]),
        (kinds.VECTOR3, [1.0, 2.0]),
        (kinds.BOOL, "yes"),
    ],
)
def test_hostile_values_are_refused_at_the_server(kind, value):
    with pytest.raises(ValueError, match="must"):
        kind.check(value)


def test_numbers_beyond_single_precision_become_infinity():
    big = 3.4028234663852886e38
    values = [big, -1e39, [1e300, 1.0], np.array([1e300]), math.inf, "text", b"bytes", 7]
    reply = decode_delivery(encode(Delivery(0, 0, 0, 0, 0, [Reply(1, 0, 0, values)]))).replies[0]
    assert reply.values == [big, -math.inf, [math.inf, 1.0], [math.inf], math.inf, "text", b"bytes", 7]


@pytest.mark.parametrize("value", [(2 - 2**-24) * 2.0**127, -1e300])
def test_the_least_number_that_overflows_does_not_fail(value):
    reply = decode_delivery(encode(Delivery(0, 0, 0, 0, 0, [Reply(1, 0, 0, [value])]))).replies[0]
    assert reply.values == [math.copysign(math.inf, value)]


@pytest.mark.parametrize(
    ("count", "values"),
    [*((count, [0.5, "text", [1e300]]) for count in (1, 15, 16)), (1 << 16, [0.5])],
)
def test_answers_packed_one_by_one_make_the_same_delivery(count: int, values: list[object]) -> None:
    replies = [Reply(1 + number, 0, 50, values) for number in range(count)]
    whole = Delivery(7, 8, 9, 1, 5, replies)
    packed = [pack_reply_head(each.call_id) + pack_answer(*each[1:]) for each in replies]
    assert decode_delivery(encode_delivery(whole._replace(replies=[]), b"".join(packed), count)) == (
        decode_delivery(encode(whole))
    )


def test_numbers_packed_together_are_the_bytes_of_replies_packed_one_by_one() -> None:
    numbers = [0.1, -0.0, 3.4028235677973366e38, -1e300, math.inf, math.nan, 5e-324, 1.0]
    ids = [1, 127, 128, 255, 256, 65535, 65536, 0x7FFF_FFFF]
    packer = NumberPacker(ids)
    for time_ms in (0, 50, 127, 128, 70_000, 50, 0x7FFF_FFFF):
        one_by_one = [
            pack_reply_head(call_id) + pack_answer(0, time_ms, [number])
            for call_id, number in zip(ids, numbers, strict=True)
        ]
        assert packer.pack(0, time_ms, numbers) == b"".join(one_by_one)


def test_a_message_after_a_large_one_and_after_one_that_cannot_be_packed_is_whole() -> None:
    expected = encode(Batch(1, 2, []))
    encode(Batch(1, 2, [Call(1, 0, 0, "simxSetStringSignal", [bytes(1 << 20)])]))
    assert encode(Batch(1, 2, [])) == expected
    with pytest.raises(TypeError):
        encode(Batch(1, 2, [Call(1, 0, 0, "simxSetStringSignal", [object()])]))
    assert encode(Batch(1, 2, [])) == expected
