"""Topics and services of the scene's scripts, as `parts/communication/ros2_topics.py` asks for them. Physics thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.parts.communication.ros2_topics import TopicQuality
from simx_server.ros2_messages import MessageError, MessageType, ServiceType
from simx_server.sensors.vision.futures import then

from .node import Node
from .wire.endpoint import Endpoint
from .wire.names import is_name
from .wire.publisher import Publisher
from .wire.qos import Qos
from .wire.service import Request, Service
from .wire.service_client import ServiceClient


class ScriptTopics:
    """The endpoints of scripts, which the gateway declares."""

    def __init__(self, node: Node, changed: Callable[[], object]) -> None:
        """Offer nothing yet.

        Args:
            changed: called when `endpoints` has changed.
        """
        self.endpoints: list[Endpoint] = []
        self._node, self._client, self._types = node, node.client, node.types
        self._changed = changed

    def knows(self, kind: str) -> bool:
        return kind in self._types.messages or kind in self._types.services

    def publish(self, topic: str, kind: str, quality: TopicQuality) -> _ScriptPublisher:
        type_ = self._message(kind)
        publisher = self._node.publisher(self._full(topic), kind, _qos(quality))
        self.add(publisher)
        return _ScriptPublisher(self, publisher, type_)

    def subscribe(
        self, topic: str, kind: str, quality: TopicQuality, receive: Callable[[Mapping[str, Any]], object]
    ) -> _Closable:
        type_ = self._message(kind)

        def take() -> None:
            payload = subscription.take()
            if payload is None or subscription not in self.endpoints:  # its script has closed it meanwhile
                return
            try:
                message = type_.decode(payload)
            except MessageError as problem:
                self._client.failed(subscription.full_name, problem)
            else:
                receive(message)

        subscription = self._node.subscription(
            self._full(topic), kind, _qos(quality), lambda _: self._client.post(take)
        )
        self.add(subscription)
        return _Closable(self, subscription)

    def serve(self, service: str, kind: str, answer: Callable[[Mapping[str, Any]], Any]) -> _Closable:
        type_ = self._service(kind)

        def take() -> None:
            request = server.take()
            if request is not None:
                self._answer(server, type_, request, answer)

        server = self._node.service(
            self._full(service),
            kind,
            lambda _: self._client.post(take),
            lambda why: type_.response.encode(_refused(type_, why)),
        )
        self.add(server)
        return _Closable(self, server)

    def _answer(
        self,
        server: Service,
        type_: ServiceType,
        request: Request,
        answer: Callable[[Mapping[str, Any]], Any],
    ) -> None:
        """Have a script answer a request; what goes wrong is logged, and said where the response has room for it."""
        try:
            wanted = type_.request.decode(request.payload)
            made = answer(wanted) if server in self.endpoints else None
            if made is None:
                raise CommandError(f"the script that serves {server.full_name} has given no response")
            response = type_.response.encode(type_.response.fill(made))
        except CommandError as problem:
            self._client.failed(server.full_name, problem)
            response = type_.response.encode(_refused(type_, str(problem)))
        request.answer(response)

    def client(self, service: str, kind: str) -> _ScriptClient:
        type_ = self._service(kind)
        made = self._node.service_client(self._full(service), kind)
        self.add(made)
        return _ScriptClient(self, made, type_)

    def add(self, endpoint: Endpoint) -> None:
        """Have an endpoint declared."""
        self.endpoints.append(endpoint)
        self._changed()

    def remove(self, endpoint: Endpoint) -> None:
        """Take an endpoint back."""
        self.endpoints.remove(endpoint)
        self._changed()

    def _full(self, name: str) -> str:
        """Return the full name of a topic or service of a script. Raises CommandError."""
        plain = name if name.startswith(("/", "~")) else f"/{name}"
        full = self._node.place.full(plain)
        if not is_name(full):
            raise CommandError(
                f"'{name[:80]}' is not a name of ROS 2; valid are letters, digits, underscores, and slashes between "
                "parts, none of which starts with a digit"
            )
        return full

    def _message(self, kind: str) -> MessageType:
        if kind not in self._types.messages:
            raise CommandError(
                f"the type '{kind[:80]}' is not known{did_you_mean(kind, list(self._types.messages))}"
            )
        return self._types.messages[kind]

    def _service(self, kind: str) -> ServiceType:
        if kind not in self._types.services:
            raise CommandError(
                f"the type '{kind[:80]}' is not known{did_you_mean(kind, list(self._types.services))}"
            )
        return self._types.services[kind]


class _Closable:
    def __init__(self, topics: ScriptTopics, endpoint: Endpoint) -> None:
        self._topics, self._endpoint = topics, endpoint

    def close(self) -> None:
        self._topics.remove(self._endpoint)


class _ScriptPublisher(_Closable):
    def __init__(self, topics: ScriptTopics, publisher: Publisher, type_: MessageType) -> None:
        super().__init__(topics, publisher)
        self._publisher, self._type = publisher, type_

    def send(self, message: Any) -> None:
        # Checked in any case: a script fails in the same way each time.
        checked = self._type.fill(message)
        if self._publisher.is_wanted:
            self._publisher.put(self._type.encode(checked))


class _ScriptClient(_Closable):
    def __init__(self, topics: ScriptTopics, client: ServiceClient, type_: ServiceType) -> None:
        super().__init__(topics, client)
        self._client, self._type = client, type_

    @property
    def is_served(self) -> bool:
        return self._client.is_served

    def call(self, request: Any) -> Future[dict[str, Any]]:
        payload = self._type.request.encode(self._type.request.fill(request))
        return then(self._client.call(payload), self._type.response.decode)


def _qos(quality: TopicQuality) -> Qos:
    return Qos(quality.depth, quality.is_reliable, quality.is_transient_local)


def _refused(type_: ServiceType, why: str) -> Mapping[str, Any]:
    """Return a response that says that a request was not executed, as far as the type can."""
    response = type_.response.default()
    if "message" in response and "success" in response:
        response["message"] = why
    return response
