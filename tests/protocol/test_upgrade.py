"""Messages of version 1 of the protocol are understood for as long as a server supports that version.

``fixtures/protocol_1`` holds bytes that were made once, by the client and the server of that time, and what they mean;
nothing here makes them again. The scene lies beside them, so that handles stay what they were.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import pytest
from loopback import LoopbackTransport
from processes import server
from real_world import RealWorld

from simx_client.protocol import codec
from simx_client.protocol.codec import CodecError
from simx_client.protocol.messages import OLDEST_PROTOCOL, PROTOCOL_VERSION, choose_version, no_common_version
from simx_client.protocol.zenoh import link

pytestmark = [pytest.mark.slow, pytest.mark.gl]

FIXTURES = Path(__file__).parent / "fixtures"
V1 = FIXTURES / "protocol_1"
CLIENT = "a1b2c3"
ERROR = 8


def read(name: str) -> list[dict[str, Any]]:
    return json.loads((V1 / name).read_text())


def plain(value: Any) -> Any:
    """A message as the fixtures write it."""
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    return [plain(each) for each in value] if isinstance(value, (list, tuple)) else value


def replies_of(payload: bytes) -> dict[int, tuple[int, Any]]:
    """Status and values by call id, read as the client of that time did: six fields, four in each reply."""
    message = msgpack.unpackb(payload, unicode_errors="surrogateescape")
    assert [type(field) for field in message] == [int, int, int, int, int, list]
    for reply in message[5]:
        assert [type(field) for field in reply] == [int, int, int, list]
    return {reply[0]: (reply[1], plain(reply[3])) for reply in message[5]}


Exchange = Callable[[bytes, set[int]], dict[int, tuple[int, Any]]]
"""Sends a batch; the replies to these calls."""


def replay(exchange: Exchange) -> None:
    """A whole session of the old client."""
    for entry in read("session.json"):
        # The answer to a discontinued stream was not waited for then; it may come.
        wanted = {call: (status, values) for call, status, values in entry["answers"] if status is not None}
        answers = exchange(bytes.fromhex(entry["bytes"]), set(wanted))
        for call, (status, values) in wanted.items():
            assert answers[call][0] == status, (entry["what"], answers[call])
            if status == ERROR:  # in words, which may change
                assert isinstance(answers[call][1][0], str)
            elif values is not None:
                assert answers[call][1] == values, entry["what"]


# --- bytes ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("entry", read("messages.json"), ids=lambda entry: f"{entry['kind']}-{entry['what']}")
def test_old_messages_mean_what_they_meant(entry: dict[str, Any]) -> None:
    found = getattr(codec, f"decode_{entry['kind']}")(bytes.fromhex(entry["bytes"]))
    assert plain(found)[: len(entry["means"])] == entry["means"]


@pytest.mark.parametrize("entry", read("messages.json"), ids=lambda entry: f"{entry['kind']}-{entry['what']}")
def test_fields_that_a_newer_peer_adds_are_left_out_where_that_is_promised(entry: dict[str, Any]) -> None:
    """In the messages by which strangers meet, never in those that carry calls: see docs/internals/protocol.md."""
    decode = getattr(codec, f"decode_{entry['kind']}")
    fields = msgpack.unpackb(bytes.fromhex(entry["bytes"]), unicode_errors="surrogateescape")
    if entry["kind"] == "greeting":
        fields.append(fields[0])  # the newest version, the first field that was added
    elif entry["kind"] == "welcome":
        fields.append("")  # the socket for clients on its host
    known = decode(_packed(fields))
    longer = _packed([*fields, "new", [1, {"more": 2}]])
    if entry["kind"] in ("greeting", "welcome", "status"):
        assert decode(longer) == known
    else:
        with pytest.raises(CodecError, match="fields"):
            decode(longer)


def _packed(value: Any) -> bytes:
    return msgpack.packb(value, unicode_errors="surrogateescape", use_single_float=True)


def test_all_versions_that_are_spoken_have_their_fixtures() -> None:
    """A new version: freeze its bytes too. An old one may be dropped with its folder."""
    spoken = {f"protocol_{version}" for version in range(OLDEST_PROTOCOL, PROTOCOL_VERSION + 1)}
    assert {folder.name for folder in FIXTURES.iterdir() if folder.name.startswith("protocol_")} == spoken


# --- an old client and a server of today --------------------------------------------------------------


@pytest.fixture
def world(tmp_path: Path) -> Iterator[RealWorld]:
    world = RealWorld(V1 / "scene.xml", workspace=tmp_path)
    yield world
    world.close()


def loop(world: RealWorld) -> Exchange:
    transport = LoopbackTransport(world.loop)
    transport.greet(1.0)

    def exchange(batch: bytes, wanted: set[int]) -> dict[int, tuple[int, Any]]:
        transport.send(batch)
        found: dict[int, tuple[int, Any]] = {}
        while not wanted <= found.keys():
            payload = transport.receive(5.0)
            assert payload, f"no answer to {sorted(wanted - found.keys())}"
            found |= replies_of(payload)
        return found

    return exchange


def test_session_of_an_old_client_gets_the_answers_it_got(world: RealWorld) -> None:
    replay(loop(world))


def test_every_command_of_the_old_table_is_still_there(world: RealWorld) -> None:
    exchange = loop(world)
    entries = read("every_command.json")
    assert len({entry["what"] for entry in entries}) > 100
    for entry in entries:
        batch = bytes.fromhex(entry["bytes"])
        calls = msgpack.unpackb(batch, unicode_errors="surrogateescape")[2]
        answers = exchange(batch, {call[0] for call in calls})
        for call in calls:
            status, values = answers[call[0]]
            assert status in (0, ERROR)
            if status == ERROR:
                assert values[0].startswith(f"{call[3]}: "), values
                assert "argument" not in values[0], values
                assert "there is no command" not in values[0], values


def test_old_client_is_let_in_and_served_over_zenoh(tmp_path: Path) -> None:
    """With nothing but Zenoh, the keys as they were, and bytes that were frozen."""
    zenoh = link.import_zenoh()
    greeting, welcome = (
        next(m for m in read("messages.json") if m["kind"] == kind) for kind in ("greeting", "welcome")
    )
    with server(V1 / "scene.xml", "--workspace", str(tmp_path)) as process:
        config = zenoh.Config()
        for path, value in (
            ("mode", '"client"'),
            ("scouting/multicast/enabled", "false"),
            ("connect/endpoints", f'["tcp/127.0.0.1:{process.port}"]'),
        ):
            config.insert_json5(path, value)
        with zenoh.open(config) as session:
            realm = f"simx-{process.port}"
            token = session.liveliness().declare_token(f"simx/{realm}/client/{CLIENT}")
            replies = session.declare_subscriber(
                f"simx/{realm}/reply/{CLIENT}", zenoh.handlers.FifoChannel(256)
            )
            came: list[bytes] = []
            for _ in range(500):  # without an answer until the server has seen the token
                answers = session.get(
                    f"simx/{realm}/hello", payload=bytes.fromhex(greeting["bytes"]), timeout=5.0
                )
                came = [answer.ok.payload.to_bytes() for answer in answers if answer.ok is not None]
                if came:
                    break
            fields = msgpack.unpackb(came[0])
            assert [type(field) for field in fields][:5] == [type(field) for field in welcome["means"]]
            assert fields[:3] == [1, "", realm], "taken in, in its own version"

            def exchange(batch: bytes, wanted: set[int]) -> dict[int, tuple[int, Any]]:
                session.put(f"simx/{realm}/call/{CLIENT}", batch)
                found: dict[int, tuple[int, Any]] = {}
                while not wanted <= found.keys():
                    found |= replies_of(replies.recv().payload.to_bytes())
                return found

            replay(exchange)
            token.undeclare()


# --- which version is spoken --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("client", "server_speaks", "chosen"),
    [
        ((1, 1), (1, 1), 1),
        ((1, 1), (1, 3), 1),  # an old client, which says one number only
        ((1, 3), (1, 1), 1),
        ((1, 3), (2, 5), 3),
        ((2, 3), (1, 2), 2),
        ((1, 1), (2, 3), None),
        ((2, 3), (1, 1), None),
    ],
)
def test_newest_version_that_both_speak_is_spoken(
    client: tuple[int, int], server_speaks: tuple[int, int], chosen: int | None
) -> None:
    assert choose_version(client, server_speaks) == chosen


def test_who_is_behind_is_told_to_upgrade() -> None:
    assert "(the client speaks 1, the server 2 to 3); upgrade the client" in no_common_version((1, 1), (2, 3))
    assert "(the client speaks 2 to 3, the server 1); upgrade the server" in no_common_version((2, 3), (1, 1))


def test_greeting_of_a_client_that_says_one_version_means_that_one() -> None:
    (old, *_) = (m for m in read("messages.json") if m["kind"] == "greeting")
    greeting = codec.decode_greeting(bytes.fromhex(old["bytes"]))
    assert (greeting.protocol, greeting.newest) == (1, 1)
