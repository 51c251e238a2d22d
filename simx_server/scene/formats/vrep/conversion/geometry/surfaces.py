"""Friction and bounce of contacts, from the parameters of the physics engine that a scene uses.

V-REP's engines multiply the friction of the two shapes (Bullet, ODE and Newton, by V-REP's manual; Vortex takes the
lower one). MuJoCo takes the larger one, or that of the geom with the higher priority. So each shape gets the friction
that it has with the scene's ground, and the priority grows with the difference from the ground's own friction:

* Contacts with the ground, and with everything of the ground's friction, have exactly V-REP's value.
* Between two other shapes the one that differs more from the ground decides: a slippery caster stays slippery on
  anything.

Bounce is treated in the same way. MuJoCo as an engine has MuJoCo's own rules, and its parameters are kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Engine, Shape, Surface, VrepFile

from .damage import undamaged

_USUAL = 0.71
"""Friction of V-REP's default material in Bullet and ODE."""

_DEFAULT_GROUND = (1.0, 0.5)
"""Friction and restitution of V-REP's default floor, on which a model stands."""

_MOST = 10.0
"""Bullet cuts a combined friction there."""

_TIME_CONSTANT = 0.005
"""Of contacts in seconds; MuJoCo's default of 0.02 lets things sink in visibly."""

_TORSION, _ROLLING = 0.005, 0.0001
"""MuJoCo's defaults; V-REP's engines have neither."""

_SLIPPERY = 1e-3
"""Friction below which there is none."""

_FRICTION_AT = {Engine.BULLET: 1, Engine.ODE: 0, Engine.VORTEX: 0, Engine.NEWTON: 0}
"""Place of the friction in an engine's real numbers; Bullet's is that of version 2.78, V-REP's default."""

_NEWER_BULLET_AT = 2
"""The same for Bullet 2.83, whose number often differs for the same material."""

_DAMPING_AT: dict[Engine, tuple[int, ...]] = dict.fromkeys((Engine.BULLET, Engine.ODE, Engine.NEWTON), (3, 4))
"""Places of the damping of linear and of angular motion."""

_RESTITUTION_AT = {Engine.BULLET: 0, Engine.NEWTON: 2}


@dataclass(frozen=True)
class Contact:
    """The parameters of a geom's contacts in MuJoCo."""

    friction: tuple[float, float, float]
    solref: tuple[float, float]
    priority: int = 0
    condim: int = 3
    solimp: tuple[float, ...] | None = None
    solmix: float = 1.0
    margin: float = 0.0

    def apply(self, geom: Any) -> None:
        """Give these contacts to a geom of an MjSpec."""
        geom.friction[:], geom.solref[:] = self.friction, self.solref
        geom.priority, geom.condim = self.priority, self.condim
        geom.solmix, geom.margin = self.solmix, self.margin
        if self.solimp is not None:
            geom.solimp[:] = self.solimp


@dataclass(frozen=True)
class Surfaces:
    """The contacts of one file's shapes."""

    engine: Engine
    ground: tuple[float, float]
    """Friction and restitution of the shape that most others stand on."""
    has_newer_bullet: bool = False
    """Whether Bullet is version 2.83."""

    @classmethod
    def of(cls, conversion: Conversion) -> Surfaces:
        """Return the contacts of a conversion's file."""
        return conversion.part(cls, lambda: cls.of_file(conversion.file))

    @classmethod
    def of_file(cls, file: VrepFile) -> Surfaces:
        """Return the contacts of a file."""
        engine, is_newer = file.settings.engine, file.settings.has_newer_bullet
        ground = None if file.is_model else ground_of(file.objects.values())
        values = _DEFAULT_GROUND if ground is None else _values(ground.surface, engine, is_newer)
        return cls(engine, values, is_newer)

    def is_damped(self, shape: Shape) -> bool:
        """Return whether the engine slows a shape down on its own, as a viscous medium does."""
        places = _DAMPING_AT.get(self.engine, ())
        return any(_number(shape.surface, self.engine, place) for place in places)

    def contact_of(self, shape: Shape) -> Contact:
        """Return the contacts of a respondable shape."""
        if self.engine == Engine.MUJOCO and (own := _of_mujoco(shape.surface)) is not None:
            return own
        friction, bounce = _values(shape.surface, self.engine, self.has_newer_bullet)
        ground_friction, ground_bounce = self.ground
        together = min(friction * ground_friction, _MOST)
        rank = 0 if friction == ground_friction else min(1000, round(100 * _ratio(friction, ground_friction)))
        restitution = min(
            bounce + ground_bounce if self.engine == Engine.NEWTON else bounce * ground_bounce, 0.95
        )
        if bounce != ground_bounce:
            rank += 1 + round(100 * restitution)
        # With a little friction left, MuJoCo's solver may throw light things about.
        condim = 1 if together < _SLIPPERY else 3
        return Contact((together, _TORSION, _ROLLING), bouncing(restitution), rank, condim)


def bouncing(restitution: float) -> tuple[float, float]:
    """Return the `solref` of contacts that give back a share of the speed, 0 up to, but not, 1.

    All have the stiffness of contacts without bounce. Those are critically damped, and give back 0.135, too.
    """
    low, high = 0.01, 1.0
    if restitution <= _returned(high):
        return _TIME_CONSTANT, 1.0
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if _returned(middle) > restitution else (low, middle)
    return _TIME_CONSTANT / high, high


def _returned(damping: float) -> float:
    """Return the share of the speed that a spring with a damping ratio up to 1 gives back: it lets go at force 0."""
    swing = math.sqrt(1.0 - damping * damping)
    if swing < 1e-6:
        return math.exp(-2.0)
    phase = math.pi - math.atan2(2 * damping * swing, 1 - 2 * damping * damping)
    return math.exp(-damping / swing * phase)


def _values(surface: Surface | None, engine: Engine, has_newer_bullet: bool) -> tuple[float, float]:
    """Return friction and restitution in an engine; what it lacks is taken from Bullet, which all files have."""
    friction = restitution = None
    if engine == Engine.BULLET and has_newer_bullet:
        friction = _number(surface, engine, _NEWER_BULLET_AT)
    for each in (engine, Engine.BULLET, Engine.ODE):
        friction = _number(surface, each, _FRICTION_AT.get(each)) if friction is None else friction
    for each in (engine, Engine.BULLET):
        restitution = (
            _number(surface, each, _RESTITUTION_AT.get(each)) if restitution is None else restitution
        )
    return min(_USUAL if friction is None else friction, 1000.0), min(restitution or 0.0, 1.0)


def _number(surface: Surface | None, engine: Engine, place: int | None) -> float | None:
    reals = surface.engines.get(engine, ([], []))[0] if surface is not None else []
    if place is None or place >= len(reals) or not math.isfinite(reals[place]):
        return None
    return max(0.0, float(reals[place]))


def _ratio(friction: float, ground: float) -> float:
    """Return how far apart two frictions are, as a logarithm; frictions of 0.0001 and less are alike."""
    return abs(math.log(max(friction, 1e-4) / max(ground, 1e-4)))


def _of_mujoco(surface: Surface | None) -> Contact | None:
    """Return the parameters that CoppeliaSim gives to MuJoCo; None where they are missing or not valid there.

    Its real numbers are friction (3), solref (2), solimp (5), solmix and margin, its whole ones condim and priority.
    """
    reals, wholes = surface.engines.get(Engine.MUJOCO, ([], [])) if surface is not None else ([], [])
    if len(reals) < 12 or len(wholes) < 2 or not np.isfinite(reals[:12]).all():
        return None
    friction, solref, solimp = reals[:3], reals[3:5], reals[5:10]
    condim, priority = wholes[:2]
    is_valid = (
        min(friction) >= 0
        and (min(solref) > 0 or max(solref) <= 0)
        and all(0 < each < 1 for each in (*solimp[:2], solimp[3]))
        and solimp[2] >= 0
        and solimp[4] >= 1
        and condim in (1, 3, 4, 6)
        and 0 <= priority < 1 << 20
        and reals[10] > 0
        and 0 <= reals[11] < 1
    )
    if not is_valid:
        return None
    return Contact(
        (friction[0], friction[1], friction[2]),
        (solref[0], solref[1]),
        priority,
        condim,
        tuple(solimp),
        reals[10],
        reals[11],
    )


def ground_of(objects: Iterable[object]) -> Shape | None:
    """Return the static respondable shape with the largest surface from above, which is the ground."""
    static = [
        one
        for one in objects
        if isinstance(one, Shape) and one.is_respondable and not one.is_dynamic and one.leaves
    ]
    return max(static, key=_spread, default=None)


def _spread(shape: Shape) -> float:
    """Return the product of a shape's two largest sizes; leaves count as lying at one place."""
    leaves = [leaf for leaf in map(undamaged, shape.leaves) if leaf is not None]
    sizes = [np.ptp(leaf.vertices, axis=0) if len(leaf.vertices) else leaf.size for leaf in leaves]
    extent = np.sort(np.max([(0.0, 0.0, 0.0), *sizes], axis=0))
    return float(extent[-1]) * float(extent[-2])
