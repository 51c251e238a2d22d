"""The Zenoh session of the node, on a separate thread: it opens, declares what is wanted, and reopens after losses.

As a client it waits for the user's router, for any time, and the server runs meanwhile. Or it is the router itself, to
which ROS 2's nodes connect. It is never a peer: then a router would forward nothing between it and others.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

from simx_client.protocol.zenoh import link

from ...errors import GatewayError
from .endpoint import Endpoint
from .names import Place, node_token
from .pulse import Pulse
from .router import options as router_options

logger = logging.getLogger(__name__)

DEFAULT_ROUTER = "tcp/127.0.0.1:7447"
"""Where rmw_zenohd listens, and ROS 2's nodes connect."""

RETRY = 1.0
"""Seconds between two attempts to reach the router, and between two checks that it is still there."""

GRAPH_TIMEOUT = 1.0
"""Seconds for the router to say which nodes there are."""

CLOSE_TIMEOUT = 2.0
"""Seconds that Zenoh has to close the session."""

_NODE_ID = 0

_OPTIONS: dict[str, Any] = {
    **link.COMMON,
    "timestamping/enabled": True,  # rmw_zenoh's caches of transient-local topics need it
    # The physics thread waits that long for a link that is full, before it drops a message; Zenoh's default is 1 ms.
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 100,
    "transport/shared_memory": {"enabled": False},  # as for the server's other session, see link.SERVER
}


class Router(NamedTuple):
    """The router by which ROS 2's nodes are reached."""

    endpoint: str = DEFAULT_ROUTER
    is_self: bool = False
    """The session is the router, and listens there."""

    @staticmethod
    def of(text: str) -> Router:
        """Return the router of a text: an endpoint, `self`, or `self=` and an endpoint."""
        if text == "self":
            return Router(is_self=True)
        return Router(text.removeprefix("self="), text.startswith("self="))


class Ros2Session:
    """Keeps a node and its endpoints declared."""

    def __init__(self, place: Place, router: Router, pulse: Pulse) -> None:
        """Open the session, if it is the router itself; `start` does the rest.

        Args:
            pulse: looks after the nodes that trigger steps.

        Raises:
            GatewayError: it cannot listen.
        """
        self._zenoh = zenoh = link.import_zenoh()
        __import__("zenoh.ext")
        self._place, self._router, self._pulse = place, router, pulse
        self._next_pulse = 0.0
        self._session: Any = None
        self._node: Any = None
        self._declared: dict[int, Endpoint] = {}
        """Endpoints of the present session, by their number in it."""

        self._next_number = _NODE_ID + 1
        self._changed = threading.Condition()
        self._wanted: Sequence[Endpoint] = ()
        self._is_new, self._is_closing = False, False
        self._was_told = False
        """The log says that the router is missing."""

        self._thread = threading.Thread(target=self._run, name="simx-ros2", daemon=True)
        if router.is_self:
            try:
                self._session = zenoh.open(self._config())
            except zenoh.ZError as error:
                raise GatewayError(
                    f"--ros2-router self cannot listen on {router.endpoint}: {link.reason(error)}; if rmw_zenohd "
                    "or another simx-server is there, leave the flag away and be its client"
                ) from None
            self._declare_node()

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def keep(self, endpoints: Sequence[Endpoint]) -> None:
        """Have exactly these endpoints declared from now on. Any thread."""
        with self._changed:
            self._wanted, self._is_new = tuple(endpoints), True
            self._changed.notify()

    def keeps(self, endpoints: Sequence[Endpoint]) -> bool:
        """Return whether all these endpoints are declared. Any thread."""
        declared = {id(endpoint) for endpoint in self._declared.copy().values()}
        return all(id(endpoint) in declared for endpoint in endpoints)

    def close(self) -> None:
        """Leave: others notice at once. A router that takes nothing any more is not waited for."""
        with self._changed:
            self._is_closing = True
            self._changed.notify()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_TIMEOUT)
            if self._thread.is_alive():
                logger.warning("the router of ROS 2 takes nothing any more and is not waited for")
        elif self._session is not None:
            self._session.close()

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._is_new or self._is_closing, RETRY)
                wanted, self._is_new, is_closing = self._wanted, False, self._is_closing
            if is_closing:
                break
            try:
                self._work(wanted)
            except Exception:
                logger.exception("the node of ROS 2 has a fault; it tries again")
        if self._session is not None:
            try:
                self._session.close()
            except self._zenoh.ZError as error:
                logger.debug("the session of ROS 2 was not closed in good order: %s", error)

    def _work(self, wanted: Sequence[Endpoint]) -> None:
        """Open the session if there is none, and declare what is wanted."""
        try:
            if self._session is None:
                self._open()
            if self._session is not None:
                self._declare(wanted)
                self._look()
                self._feel_pulse()
        except self._zenoh.ZError as error:
            if self._session is None or not self._session.is_closed():
                logger.warning("ROS 2: %s", link.reason(error))
                return
            logger.warning("the session of ROS 2 has ended, and is opened again: %s", link.reason(error))
            self._forget()

    def _open(self) -> None:
        """Connect to the router, or log once that it is missing."""
        try:
            self._session = self._zenoh.open(self._config())
        except self._zenoh.ZError as error:
            if not self._was_told:
                self._was_told = True
                logger.warning(
                    "ROS 2 waits for a router at %s (%s); start it with: ros2 run rmw_zenoh_cpp rmw_zenohd, or have "
                    "this server be it, with --ros2-router self",
                    self._router.endpoint,
                    link.reason(error),
                )
            return
        self._warn_of_namesakes()
        self._declare_node()
        self._was_told = False
        logger.info("ROS 2 is connected to the router at %s", self._router.endpoint)

    def _config(self) -> Any:
        options = dict(_OPTIONS)
        if self._router.is_self:
            options |= router_options(self._router.endpoint, self._place)
        else:
            options |= {"mode": "client", "connect/endpoints": [self._router.endpoint]}
        return link.configure(self._zenoh.Config(), options)

    def _warn_of_namesakes(self) -> None:
        """Log that another node has the same name: both publish the same topics, which confuses all who listen."""
        place = self._place
        found = self._session.liveliness().get(node_token(place, "*", "*"), timeout=GRAPH_TIMEOUT)
        if any(reply.ok is not None for reply in found):
            logger.warning(
                "another node of ROS 2 is called %s/%s in domain %d: both publish the same topics; give this server "
                "another domain, with --ros2 N, or a --ros2-namespace",
                place.namespace,
                place.node,
                place.domain,
            )

    def _declare_node(self) -> None:
        token = node_token(self._place, str(self._session.info.zid()), _NODE_ID)
        self._node = self._session.liveliness().declare_token(token)

    def _declare(self, wanted: Sequence[Endpoint]) -> None:
        kept = {id(endpoint) for endpoint in wanted}
        for number, endpoint in [*self._declared.items()]:
            if id(endpoint) not in kept:
                del self._declared[number]
                endpoint.undeclare()
        known = {id(endpoint) for endpoint in self._declared.values()}
        for endpoint in wanted:
            if id(endpoint) not in known:
                number = self._next_number
                self._next_number += 1
                endpoint.declare(self._zenoh, self._session, _NODE_ID, number)
                self._declared[number] = endpoint

    def _look(self) -> None:
        """Log when the router has gone, and when it is there again: Zenoh itself connects again."""
        if self._session.is_closed():
            raise self._zenoh.ZError("it is closed")
        if self._router.is_self:
            return
        info = self._session.info
        is_gone = not info.routers_zid() and not info.peers_zid()
        if is_gone != self._was_told:
            self._was_told = is_gone
            self._pulse.forget()
            text = "has gone; ROS 2 waits for it" if is_gone else "is there again"
            logger.warning("the router at %s %s", self._router.endpoint, text)

    def _feel_pulse(self) -> None:
        if not self._was_told and (now := time.monotonic()) >= self._next_pulse:
            self._next_pulse = now + RETRY
            self._pulse.look(self._zenoh, self._session)

    def _forget(self) -> None:
        """Note that the session has ended; the next one has other ids."""
        for endpoint in self._declared.values():
            endpoint.forget()
        self._declared.clear()
        self._session = self._node = None
