"""Access to the page: a link with a token once, then a cookie. The teacher's opens everything, a seat's its seat.

Cookies are ``HttpOnly``, so that no script of the page reads them, and ``SameSite=Lax``: a link in a mail or a chat
works at once, and requests of other sites that would change something come without the cookie. Requests that change
something must have this page as their ``Origin`` too.
"""

from __future__ import annotations

import hmac

from simx_server.classroom.plan import ClassPlan

from .http import Request


class Access:
    """Decides what a request may do."""

    def __init__(self, plan: ClassPlan, port: int) -> None:
        """Make the rules of one class.

        Args:
            port: of the page; cookies of one host are for all its ports, so their names have it.
        """
        self._teacher = plan.teacher
        self._seats = {seat.number: seat.token for seat in plan.seats}
        self._port = port

    def is_teacher(self, request: Request) -> bool:
        """Return whether a request has the teacher's cookie."""
        return _is_same(request.cookie(self._teachers_cookie), self._teacher)

    def may_use(self, request: Request, seat: int) -> bool:
        """Return whether a request may see and reset a seat, which exists."""
        return self.is_teacher(request) or _is_same(request.cookie(self._cookie_of(seat)), self._seats[seat])

    def teachers_login(self, token: str) -> str | None:
        """Return the cookie for the teacher's token; None for another one."""
        if not _is_same(token, self._teacher):
            return None
        return f"{self._teachers_cookie}={token}; Path=/; HttpOnly; SameSite=Lax"

    def login(self, token: str, seat: int) -> str | None:
        """Return the cookie for a seat's token; None for another one."""
        if not _is_same(token, self._seats[seat]):
            return None
        return f"{self._cookie_of(seat)}={token}; Path=/seat/{seat}; HttpOnly; SameSite=Lax"

    def is_from_here(self, request: Request) -> bool:
        """Return whether a request that changes something comes from this page."""
        scheme, _, place = request.headers.get("origin", "").partition("://")
        return scheme in ("http", "https") and place != "" and place == request.headers.get("host")

    @property
    def _teachers_cookie(self) -> str:
        return f"simx_teacher_{self._port}"

    def _cookie_of(self, seat: int) -> str:
        return f"simx_seat_{seat}_{self._port}"


def _is_same(text: str, token: str) -> bool:
    return hmac.compare_digest(text.encode(), token.encode())
