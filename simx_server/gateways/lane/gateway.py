"""The socket for clients of the same user on this host, which the physics thread reads while it waits.

A client greets over Zenoh and gets an offer in its welcome. With its token it connects here. It leaves when its
connection ends, as it does when its link over Zenoh ends.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from simx_client.protocol.lane.frames import FILE
from simx_client.protocol.lane.offer import (
    Offer,
    is_possible,
    is_same_user,
    made_folder,
    new_name,
    new_token,
    path_of,
)
from simx_server.gateways.zenoh.offers import Offers

from .link import EitherLink, LaneLink
from .peers import LanePeer, LanePeers

if TYPE_CHECKING:
    from simx_server.gateways.gateway import Opening
    from simx_server.service.answers.link import Link
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

MOST_STRANGERS = 64
"""Connections that have not shown a token yet; of more, the one that came first is closed."""

SILENCE = 10.0
"""Seconds that a connection has for its token."""

BACKLOG = 128
"""Connections that the system keeps until they are accepted."""


def open_lane(opening: Opening) -> LaneGateway | None:
    """Open the lane, unless a configuration of Zenoh may have rules that it would pass by."""
    settings = opening.settings
    if not settings.local or settings.config is not None or not is_possible():
        return None
    try:
        return LaneGateway(opening.service)
    except OSError as problem:
        logger.warning("clients on this host use Zenoh alone: no socket could be made: %s", problem)
        return None


class LaneGateway(LanePeers, Offers):
    """Serves clients that the Zenoh gateway has accepted."""

    silence = SILENCE
    unsaid = "it has sent no token"
    crowded = "it has no token yet, and others need its place"

    def __init__(self, service: Service) -> None:
        """Listen. Raises OSError: no socket can be made."""
        folder = made_folder()
        _remove_dead(folder)
        self._name = new_name()
        self.path = path_of(folder, self._name)
        self._guests: dict[str, EitherLink] = {}
        """The links of the clients that have an offer, by token."""

        super().__init__(service, [_listen(folder, self.path)], logger)

    # --- greetings: Offers -------------------------------------------------------------------------

    def invite(self, client: str, link: Link) -> Link:
        """Make an offer for a client that joins; return its link, which goes over to the lane with its first batch."""
        token = new_token()
        guest = EitherLink(client, token, link, partial(self._guests.pop, token, None))
        self._guests[token] = guest
        return guest

    def offer_to(self, client: str) -> str:
        """Return the offer in a client's welcome; empty for a client that has not joined."""
        guest = self._guest(client)
        return "" if guest is None else str(Offer(guest.token, self._name))

    def serves(self, client: str) -> bool:
        """Return whether a client uses its offer."""
        guest = self._guest(client)
        return guest is not None and guest.lane is not None

    def _guest(self, client: str) -> EitherLink | None:
        """Return the link of a client with an offer."""
        session = self._service.clients.sessions.get(client)
        return session.link if session is not None and isinstance(session.link, EitherLink) else None

    # --- connections -----------------------------------------------------------------------------

    def close(self) -> None:
        """Close the connections and the socket. Idempotent."""
        super().close()
        with contextlib.suppress(OSError):
            os.unlink(self.path)

    def _objection(self, connected: socket.socket) -> bool:
        if is_same_user(connected):
            return False
        self._say_closed("it comes from another user")
        return True

    def _crowd(self, host: str) -> Sequence[LanePeer]:
        strangers = [each for each in self._peers if each.is_stranger]
        return strangers if len(strangers) >= MOST_STRANGERS else ()

    def _introduce(self, peer: LanePeer) -> None:
        """Recognise a client by its token, and send it the memory of its values."""
        kind, token = peer.frames.whole.popleft()
        guest = self._guests.get(token.decode("ascii", "replace"))
        if guest is None:
            peer.problem = "it has no valid token"
            return
        forget = partial(self._forget, peer)
        try:
            link = LaneLink(
                self._service, guest.client, peer.socket, guest.first, forget, takes_files=kind == FILE
            )
        except OSError as problem:
            peer.problem = f"there is no memory for its client: {problem}"
        else:
            peer.begin(guest, link)


def _listen(folder: Path, path: str) -> socket.socket:
    """Return a listening socket. It gets its name when it listens, so that no other server takes it for a dead one."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    early = str(folder / new_name())
    try:
        listener.setblocking(False)
        listener.bind(early)
        os.chmod(early, 0o600)
        listener.listen(BACKLOG)
        os.rename(early, path)
    except BaseException:
        listener.close()
        with contextlib.suppress(OSError):
            os.unlink(early)
        raise
    return listener


def _remove_dead(folder: Path) -> None:
    """Remove the sockets of servers that were killed."""
    for path in folder.glob("*.sock"):
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            probe.setblocking(False)
            try:
                probe.connect(str(path))
            except ConnectionRefusedError:
                path.unlink()
