"""THE TABLE: every function of the legacy remote API, once.

From it follow the client's functions and type stubs, the server's dispatch and argument checks, the coverage listing,
the reference pages, and what ``simx call``, completion and ``simx-check`` know of a function. A function that is not
here does not exist; a handler without an entry is refused when the server starts.

The entries are in ``table/``, a file per family. ``table/command.py`` lists what an entry can say.
"""

from __future__ import annotations

from .table.collisions import COLLISIONS
from .table.command import Command as Command
from .table.command import Effect as Effect
from .table.command import Place as Place
from .table.command import Value as Value
from .table.connection import CONNECTION
from .table.editing import EDITING, OF_CLIENT, OF_SERVER
from .table.joints import JOINTS
from .table.objects import OBJECTS
from .table.parameters import PARAMETERS
from .table.scripts import CARRIED as CARRIED
from .table.scripts import SCRIPTS
from .table.sensors import SENSORS
from .table.signals import SIGNALS
from .table.simulation import SIMULATION
from .table.user_interface import USER_INTERFACE

TABLE: tuple[Command, ...] = (
    *CONNECTION,
    *SIMULATION,
    *OBJECTS,
    *EDITING,
    *JOINTS,
    *SENSORS,
    *COLLISIONS,
    *PARAMETERS,
    *SIGNALS,
    *SCRIPTS,
    *USER_INTERFACE,
)
"""Every command, in the order of the reference."""

BY_NAME: dict[str, Command] = {name: command for command in TABLE for name in command.names}
"""Every public name, aliases included, to its command."""

ANSWERED: dict[str, Command] = {
    name: command
    for command in (*TABLE, *CARRIED, *OF_CLIENT, *OF_SERVER)
    if command.place is not Place.LOCAL
    for name in command.names
}
"""Every name that a server may be sent to its command."""

TRIGGER = "simxSynchronousTrigger"
"""The one command that is answered after a simulation step."""
