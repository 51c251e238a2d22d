"""The sensors that were handled: in V-REP an image is the background until a simulation step or a script handles it.

Clients of the legacy remote API see the scene also before that, `sim` functions do not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.objects import ObjectKind

from .sensor_settings import Sensor, SensorSettings

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.simulation.simulation import Simulation


class HandledSensors(SensorSettings):
    """Settings of all sensors, and which of them have an image in V-REP."""

    def __init__(self, sim: Simulation, collections: Collections) -> None:
        super().__init__(sim, collections)
        self._handled: set[int] = set()
        """The sensors that a simulation step or a script has handled in this run, since their last resolution."""

    def handle_automatic(self, handle: int) -> None:
        """Handle a sensor that each simulation step handles; its image is rendered on request."""
        self.change(handle)
        self._handled.add(handle)

    def reset(self, handle: int) -> None:
        """Delete the image and its findings until the next handling. Raises UnknownHandle, WrongKind."""
        self.change(handle)
        self._blank(handle)

    def change(self, handle: int, **values: float | int) -> None:
        """Change settings by field name, as `SensorSettings.change`; another resolution blanks the image."""
        super().change(handle, **values)
        if "width" in values or "height" in values:
            self._blank(handle)
        elif "external" in values:
            self._sim.parts.replan()

    def _blank(self, handle: int) -> None:
        self._handled.discard(handle)
        self._sim.parts.replan()

    def _is_blank(self, sensor: Sensor) -> bool:
        """Return whether V-REP's image is the background: nothing was handled or set."""
        settings = sensor.settings
        given = (settings.drawn, settings.filtered, settings.filtered_depth)
        is_given = any(each is not None for each in given)
        return not is_given and settings.image is None and sensor.item.handle not in self._handled

    def _are_some_new(self) -> bool:
        """Return whether the next simulation step handles a sensor for the first time."""
        return not self._in_each_step() <= self._handled

    def _handle_new(self) -> None:
        """Note that a simulation step has handled all sensors that it does handle."""
        if self._are_some_new():
            self._handled |= self._in_each_step()
            self._sim.parts.replan()

    def _in_each_step(self) -> set[int]:
        """Return the sensors that each simulation step handles, unless that is switched off."""
        handles = self._sim.scene.of_kind(ObjectKind.VISION_SENSOR)
        settings = {handle: self._settings.get(handle) or self.settings(handle) for handle in handles}
        return {handle for handle, one in settings.items() if not one.explicit and not one.external}
