"""When the server is a node of ROS 2. The rest is slow to import, and often not needed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.zenoh import link

if TYPE_CHECKING:
    from simx_server.gateways.gateway import Opening

    from .gateway import Ros2Gateway


def open_ros2(opening: Opening) -> Ros2Gateway | None:
    """Be a node, if the settings name a domain. Raises GatewayError: it cannot be the router, as it is told to."""
    settings = opening.settings
    if settings.ros2 is None:
        return None
    from .gateway import Ros2Gateway, Ros2Options
    from .wire.names import Distribution, Place
    from .wire.session import Router

    humble, newer = Distribution.HUMBLE, Distribution.NEWER
    options = Ros2Options(
        place=Place(settings.ros2, settings.ros2_namespace or ""),
        router=Router.of(settings.ros2_router),
        distribution=humble if settings.ros2_distro == "humble" else newer,
        drive=settings.ros2_drive,
        readers=link.READERS if settings.config is None and not settings.multicast_scouting else 0,
    )
    return Ros2Gateway(opening.service, options)
