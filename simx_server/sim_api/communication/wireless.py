"""Wireless messages between scripts, see `wireless.py` of the server."""

from __future__ import annotations

import math

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.parts.communication.wireless import NO_ANTENNA, Address, Area
from simx_server.scripting.targets import find_group
from simx_server.sim_api.base import HANDLE_SELF, ApiPart

_ANY = -1


class WirelessFunctions(ApiPart):
    """Functions for wireless messages of V-REP 3: metres, radians, simulated seconds."""

    def sendData(
        self,
        target: int,
        header: int,
        name: str,
        data: bytes,
        antenna: int = HANDLE_SELF,
        radius: float = 100.0,
        vertical_angle: float = math.pi,
        horizontal_angle: float = 2 * math.pi,
        persistence: float = 0.0,
    ) -> int:
        """Send a message to the script `target`, or with sim.handle_all, sim.handle_tree or sim.handle_chain to all
        scripts, those below or those above the script's object; return 1.

        It can be received for `persistence` seconds (0: 1.5 simulation steps) within `radius` of the antenna and the
        opening angles about its xy plane and about its x axis. `antenna`: an object; sim.handle_default is the
        world's origin.
        """
        if radius < 0 or vertical_angle < 0 or horizontal_angle < 0:
            raise CommandError("the radius and the angles of a transmission are not below 0")
        self._world.wireless.send(
            self._script.handle,
            Address(header, name, self._receivers(target)),
            data,
            self._antenna(antenna),
            Area(radius, vertical_angle, horizontal_angle),
            persistence,
        )
        return 1

    def receiveData(
        self, header: int = _ANY, name: str | None = None, antenna: int = HANDLE_SELF, index: int = _ANY
    ) -> tuple[bytes, int, int, str] | None:
        """Return the data of the first message that reaches the antenna, the sender's script, header and name; nil
        without one. A script receives each message once; an index from 0 reads without receiving.

        `header` -1 and `name` nil mean any.
        """
        found = self._world.wireless.receive(
            self._script.handle,
            None if header == _ANY else header,
            name,
            self._antenna(antenna),
            None if index < 0 else index,
        )
        if found is None:
            return None
        return found.data, found.sender, found.address.header, found.address.name

    def _antenna(self, handle: int) -> int:
        if handle == c.sim_handle_default:
            return NO_ANTENNA
        return self._self(handle)

    def _receivers(self, target: int) -> frozenset[int] | None:
        scripts = self._world.scripts
        if target == c.sim_handle_all:
            return None
        group = find_group(scripts, self._sim.scene, target, self._owner)
        if group is not None:
            return frozenset(one.handle for one in group)
        if scripts.get(target) is None:
            raise CommandError(
                f"{target} is no receiver; give sim.handle_all, sim.handle_tree, sim.handle_chain or the "
                f"handle of a script; scripts of this scene: {scripts.list_scripts()}"
            )
        return frozenset([target])
