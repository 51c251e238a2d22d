# pyright: reportMissingImports=false, reportArgumentType=false
"""ROS 2 nodes of the package zenoh-ros2-sdk, in a separate process: another implementation than ours.

    python sdk_node.py PORT

It reads commands as lines of JSON, and answers each with a line `{"done": ...}`:

    {"subscribe": [TOPIC, TYPE, QOS or null, DOMAIN (0)]}
    {"publish": [TOPIC, TYPE, {FIELD: VALUE}]}
    {"call": [SERVICE, TYPE, REQUEST, RESPONSE, {FIELD: VALUE}]}     REQUEST, RESPONSE: definitions
    {"serve": [SERVICE, TYPE, REQUEST, RESPONSE, {FIELD: VALUE}]}    answers all calls with these values
    {"topics": [DOMAIN (0)]}, {"services": [DOMAIN (0)]}             names and types
    {"info": [TOPIC, DOMAIN (0)]}                                    its publishers: node, namespace, hash, QoS

A message that arrives is a line `{"topic": TOPIC, "value": {FIELD: VALUE}}`, a request `{"service": SERVICE, ...}`.
`sdk_definitions.py` has the types.
"""

from __future__ import annotations

import dataclasses
import json
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
from sdk_definitions import STORE, more_definitions, write_definitions
from zenoh_ros2_sdk import (
    ROS2Publisher,
    ROS2ServiceClient,
    ROS2ServiceServer,
    ROS2Subscriber,
    get_service_names_and_types,
    get_topic_info,
    get_topic_names_and_types,
)
from zenoh_ros2_sdk.message_registry import get_registry, load_message_type
from zenoh_ros2_sdk.session import ZenohSession

PORT = int(sys.argv[1])

_writing = threading.Lock()


def write(line: Mapping[str, Any]) -> None:
    with _writing:
        print(json.dumps(line), flush=True)


def plain(value: Any) -> Any:
    """A message as JSON has it."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = (field.name for field in dataclasses.fields(value))
        return {name: plain(getattr(value, name)) for name in fields if not name.startswith("__")}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return value.item() if isinstance(value, np.generic) else value


def made(session: Any, kind: Any, values: Mapping[str, Any]) -> Any:
    """A message object of the SDK's type store; all fields must be given."""
    found: dict[str, Any] = {}
    for name, description in session.store.fielddefs[kind][1]:
        node, detail = int(description[0]), cast(Any, description[1])
        value = values[name]
        if node == 2:
            value = made(session, detail, value)
        elif node in (3, 4) and int(detail[0][0]) == 1 and detail[0][1][0] != "string":
            value = np.array(value, detail[0][1][0])
        elif node in (3, 4) and int(detail[0][0]) == 2:
            value = [made(session, detail[0][1], each) for each in value]
        found[name] = value
    return session.store.types[kind](**found)


class Node:
    """Keeps what commands have made."""

    def __init__(self) -> None:
        self._session = ZenohSession.get_instance("127.0.0.1", PORT)
        self._publishers: dict[tuple[str, str], Any] = {}
        self._kept: list[Any] = []

    def subscribe(self, topic: str, kind: str, qos: str | None, domain: int = 0) -> None:
        def arrived(message: Any) -> None:
            write({"topic": topic, "value": plain(message)})

        self._kept.append(ROS2Subscriber(topic, kind, arrived, router_port=PORT, qos=qos, domain_id=domain))

    def publish(self, topic: str, kind: str, values: dict[str, Any]) -> None:
        publisher = self._publishers.get((topic, kind))
        if publisher is None:
            publisher = self._publishers[topic, kind] = ROS2Publisher(topic, kind, router_port=PORT)
        message = made(self._session, kind, values)
        publisher.publish(**{field: getattr(message, field) for field, _ in STORE.fielddefs[kind][1]})

    def call(self, service: str, kind: str, request: str, response: str, values: dict[str, Any]) -> Any:
        client = ROS2ServiceClient(
            service, kind, request_definition=request, response_definition=response, router_port=PORT
        )
        request_ = made(self._session, client.request_store_type, values)
        answer = client.call(**{name: getattr(request_, name) for name in values})
        client.close()
        return plain(answer)

    def serve(self, service: str, kind: str, request: str, response: str, values: dict[str, Any]) -> None:
        def answer(asked: Any) -> Any:
            write({"service": service, "value": plain(asked)})
            return server.response_msg_class(**values)

        server = ROS2ServiceServer(
            service, kind, answer, request_definition=request, response_definition=response, router_port=PORT
        )
        self._kept.append(server)


def info(topic: str, domain: int = 0) -> Any:
    return plain(get_topic_info(topic, domain, router_port=PORT, verbose=True))


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_definitions(Path(folder))
        get_registry(folder)
        node = Node()
        for kind in more_definitions():
            load_message_type(kind)
        actions: dict[str, Callable[..., Any]] = {
            "subscribe": node.subscribe,
            "publish": node.publish,
            "call": node.call,
            "serve": node.serve,
            "topics": partial(get_topic_names_and_types, router_port=PORT),
            "services": partial(get_service_names_and_types, router_port=PORT),
            "info": info,
        }
        for line in sys.stdin:
            ((name, arguments),) = json.loads(line).items()
            try:
                write({"done": actions[name](*arguments)})
            except Exception as problem:
                write({"failed": repr(problem)})


main()
os._exit(0)  # the SDK's threads do not end by themselves
