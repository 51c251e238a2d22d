"""Find out whether the nodes that trigger simulation steps still run.

A node says nothing while it computes, so silence tells nothing. But every node has a transient-local publisher, that of
its log (``/rosout``), and Zenoh's threads of its process answer queries to the cache of that publisher, whatever the
node does meanwhile. Only a process that is frozen, or cannot be reached, does not answer.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Sequence
from typing import Any, NamedTuple

from simx_server.service.clients.sessions import FROZEN

from .names import Kind, Place, key

PERIOD = 1.0
"""Seconds between two looks, and for an answer."""

ABSENT = 10
"""Looks for which there may be no node: those of a router that was restarted come back after some seconds."""

TIMEOUT = 1.0
"""Seconds for the router to say which publishers there are."""

MOST_SESSIONS = 100
"""Sessions that are asked; where more could trigger steps, one of them counts as alive."""

_SESSION = re.compile(r"[0-9a-f]{1,32}")


class _Publisher(NamedTuple):
    """A publisher, as its token describes it."""

    session: str
    node: str
    topic: str
    dds_type: str
    hash: str
    is_transient_local: bool

    @staticmethod
    def of(token: str) -> _Publisher | None:
        """Return the publisher of a token; None if it has another form."""
        parts = token.split("/")
        if len(parts) != 13 or not _SESSION.fullmatch(parts[2]):
            return None
        durability = parts[12].split(":")[1:2]
        return _Publisher(
            parts[2], parts[8], parts[9].replace("%", "/"), parts[10], parts[11], durability == ["1"]
        )


class Pulse:
    """Asks the sessions of all nodes that publish a topic. Made by the physics thread, used by the session's too."""

    def __init__(self, place: Place, topic: str) -> None:
        """Make one that has asked no session yet.

        Args:
            topic: the full name of the topic that triggers steps.
        """
        self._place, self._topic = place, topic
        self.is_wanted = False
        """The simulation waits for these nodes now and then."""

        self.problem = ""
        """Why no step will be triggered any more; empty while one may be."""

        self._lock = threading.Lock()
        self._missed: dict[str, int] = {}
        """How many questions in succession each session has not answered."""

        self._has_seen_program = False
        """A node has published the topic that does not just belong to a command line."""

        self._absent = 0
        """Looks in succession without any node."""

    def want(self, is_wanted: bool) -> None:
        """Start again, and ask from now on, or no more. Physics thread."""
        self.forget()
        self.is_wanted = is_wanted

    def forget(self) -> None:
        """Start again: the mode was set or has ended, or the router has gone. Any thread."""
        with self._lock:
            self._missed, self._has_seen_program, self._absent, self.problem = {}, False, 0, ""

    def look(self, zenoh: Any, session: Any) -> None:
        """Ask each session once. The thread of the session, every `PERIOD` seconds.

        Raises:
            zenoh.ZError: the session is closed.
        """
        if not self.is_wanted:
            return
        missed = self._missed
        publishers = self._publishers(session)
        steppers = [each for each in publishers if each.topic == self._topic]
        sessions = {each.session for each in steppers}
        if len(sessions) <= MOST_SESSIONS:
            caches = {each.session: each for each in publishers if each.is_transient_local}
            for each in sessions & caches.keys():
                missed[each] = missed.get(each, 0) + 1
                question = _Question(missed, each)
                answered = zenoh.handlers.Callback(question.answered, question.ended, indirect=False)
                session.get(self._cache(caches[each]), answered, timeout=PERIOD)
        with self._lock:
            if missed is self._missed:
                self._judge(steppers, sessions)

    def _judge(self, steppers: Sequence[_Publisher], sessions: set[str]) -> None:
        # The nodes of command lines are hidden ones, and come and go with each command.
        self._has_seen_program |= any(not each.node.startswith("_") for each in steppers)
        self._absent = 0 if sessions else self._absent + 1
        if self._has_seen_program and self._absent > ABSENT:
            self.problem = f"no node publishes {self._topic} any more"
        elif sessions and all(self._missed.get(each, 0) > FROZEN / PERIOD for each in sessions):
            self.problem = f"nothing was heard for {FROZEN:g} s of the nodes that publish {self._topic}"
        else:
            self.problem = ""

    def _cache(self, publisher: _Publisher) -> str:
        """Return the key of a publisher's cache, with the wish for no message out of it."""
        known = key(self._place, publisher.topic, publisher.dds_type, publisher.hash)
        return f"{known}/@adv/pub/{publisher.session}/**?_max=0"

    def _publishers(self, session: Any) -> list[_Publisher]:
        """Return all publishers of the domain."""
        tokens = f"@ros2_lv/{self._place.domain}/*/*/*/{Kind.PUBLISHER.value}/**"
        replies = session.liveliness().get(tokens, timeout=TIMEOUT)
        read = (_Publisher.of(str(reply.ok.key_expr)) for reply in replies if reply.ok is not None)
        return [each for each in read if each is not None]


class _Question:
    """A question to one session, on Zenoh's threads."""

    def __init__(self, missed: dict[str, int], asked: str) -> None:
        self._missed, self._asked = missed, asked
        self._is_lost = False

    def answered(self, reply: Any) -> None:
        """Take a message of the cache, or Zenoh's note that the time is over."""
        self._is_lost |= reply.err is not None and reply.err.payload.to_bytes() == b"Timeout"

    def ended(self) -> None:
        """Note that the session runs, if it has said that there is nothing more."""
        if not self._is_lost:
            self._missed[self._asked] = 0
