"""Handlers against the table."""

from __future__ import annotations

import pytest

from simx_client.protocol.commands import ANSWERED, Place
from simx_server.handlers import HANDLERS, handler


def test_every_handler_is_a_remote_command_of_the_table() -> None:
    for name, entry in HANDLERS.items():
        assert ANSWERED[name] is entry.command
        assert entry.command.name == name
        assert entry.command.place is not Place.LOCAL


def test_a_name_that_is_not_in_the_table_is_refused() -> None:
    for name in ("simxNoSuchThing", "simxStart", "simxSetJointMaxForce"):
        with pytest.raises(LookupError):
            handler(name)


def test_a_handler_with_a_wrong_number_of_parameters_is_refused() -> None:
    with pytest.raises(TypeError, match="must take 3 parameters"):
        handler("simxSetJointPosition")(lambda sim: None)
