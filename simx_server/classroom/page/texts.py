"""Texts for students: the link of a seat, and the lines that lead a program to its server."""

from __future__ import annotations

from simx_server.classroom.addresses import in_url
from simx_server.classroom.plan import ClassPlan, Seat


def link(plan: ClassPlan, seat: Seat, port: int) -> str:
    """Return the address of a seat's own page, with its token.

    Args:
        port: of the page.
    """
    return f"http://{in_url(plan.address)}:{port}/seat/{seat.number}?token={seat.token}"


def lines(plan: ClassPlan, seat: Seat) -> dict[str, list[str]]:
    """Return the two lines to paste, by the program that reads them."""
    endpoint = f"tcp/{in_url(plan.address)}:{seat.port}"
    login = f"{seat.user}:{seat.token}"
    return {
        "Linux, macOS": [
            f"export SIMX_CONNECT={endpoint} SIMX_LOGIN={login}",
            "simx-run my_program.py",
        ],
        "Windows": [
            f'$env:SIMX_CONNECT="{endpoint}"; $env:SIMX_LOGIN="{login}"',
            "simx-run my_program.py",
        ],
        "Python": [
            "import os",
            f'os.environ.update(SIMX_CONNECT="{endpoint}", SIMX_LOGIN="{login}")',
        ],
    }
