"""Objects that an edit adds, as they are known before the model is compiled."""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.editing.copies.straight import Straight
from simx_server.scene.formats.annotations import Annotation, Annotations
from simx_server.scene.formats.loader import SceneError, compile_spec
from simx_server.scene.objects import ObjectKind, Scene, SceneObject
from simx_server.scene.poses.placing import free_joint
from simx_server.scene.tree import Addition, Builder

from .sizes import IN_BODIES, sizes_of

Element = tuple[str, str]
"""Kind and name of an element."""


@dataclass(frozen=True)
class Template:
    """Objects in the order of their handles.

    Their handles and names are not those that they get. Elements, sensors too, are counted from the first one that is
    added of their kind; so are bodies.
    """

    objects: Sequence[SceneObject]
    owners: Sequence[int]
    """For each body the parent's handle for elements of it; -1: none."""
    sizes: Mapping[str, int]
    """How many elements are added, by kind."""
    parents: Mapping[int, int]
    """Handle to parent, where the tree differs from the bodies."""
    loose: frozenset[int]
    """Bodies at the top that stand or lie for themselves."""

    @classmethod
    def of_part(cls, scene: Scene, model: mujoco.MjModel, sensors: Sequence[str]) -> Template | None:
        """Return all objects of a scene that is added to another one; None if some are in its world itself.

        Args:
            scene: the scene.
            model: its model.
            sensors: names of the model's sensors that are added, in their order.
        """
        objects = [scene.objects[handle] for handle in sorted(scene.objects)]
        return cls._of_model(model, objects, scene.owners.tolist(), scene.parent_overrides, sensors)

    @classmethod
    def of_shape(cls, name: str, *, is_free: bool) -> Template:
        """Return a shape: a body with this name, which is the object's too. `is_free`: it has a joint."""
        item = SceneObject(1, name, ObjectKind.SHAPE, -1, "body", name, 0, 0)
        return cls([item], [1], {"body": 1, "joint": int(is_free)}, {}, frozenset({0}))

    @classmethod
    def of_spec(
        cls,
        model: mujoco.MjModel,
        names: Mapping[Element, str],
        annotations: Mapping[str, dict[str, Annotation]],
        hidden: Collection[str],
    ) -> Template | None:
        """Return the objects of a model that is added to a scene; None if some are in its world itself.

        Args:
            model: the model.
            names: names of the objects.
            annotations: annotations by these names.
            hidden: names of bodies that are not objects.
        """
        builder = Builder(model, replace(Annotations(), objects=annotations), hidden, names)
        builder.build()
        owners = [builder.owner[body] for body in range(model.nbody)]
        sensors = [model.sensor(sensor).name for sensor in range(model.nsensor)]
        return cls._of_model(
            model, list(builder.objects.values()), owners, builder.annotated_parents(), sensors
        )

    @classmethod
    def _of_model(
        cls,
        model: mujoco.MjModel,
        objects: Sequence[SceneObject],
        owners: Sequence[int],
        parents: Mapping[int, int],
        sensors: Sequence[str],
    ) -> Template | None:
        if any((getattr(model, f"{prefix}_bodyid") == 0).any() for prefix in (*IN_BODIES.values(), "geom")):
            return None
        places = {model.sensor(name).id: place for place, name in enumerate(sensors)}
        return cls(
            [
                item.renumbered(
                    item.id - (item.element == "body"),
                    item.body - 1,
                    tuple(places[sensor] for sensor in item.sensors),
                )
                for item in objects
            ],
            owners[1:],
            sizes_of(model) | {"body": model.nbody - 1, "sensor": len(sensors)},
            parents,
            frozenset(
                body - 1
                for body in np.flatnonzero(model.body_parentid == 0)[1:].tolist()
                if _is_loose(model, body)
            ),
        )

    @classmethod
    def of_copies(
        cls,
        model: mujoco.MjModel,
        straight: Straight,
        names: Mapping[Element, str],
        annotations: Mapping[str, dict[str, Annotation]],
        hidden: Collection[str],
    ) -> Template:
        """Return copies of objects of a model.

        Args:
            model: the model of the originals.
            straight: their bodies.
            names: names of the originals.
            annotations: annotations by these names.
            hidden: names of bodies that are not objects.
        """
        bodies = [model.body(name).id for name in straight.names]
        builder = _OfCopies(model, straight, bodies, names, annotations, hidden)
        for body in bodies:
            builder.owner.setdefault(int(model.body_parentid[body]), -1)
            builder.add_body(body)
        builder.arrange()
        places = {"body": dict(zip(bodies, range(len(bodies)), strict=True))}
        for element in IN_BODIES:
            elements = (each for body in bodies for each in builder.leaves_of(element, body))
            places[element] = {each: place for place, each in enumerate(elements)}
        sensors = [model.sensor(name).id for name in straight.sensors]
        places["sensor"] = {each: place for place, each in enumerate(sensors)}
        return cls(
            [
                item.renumbered(
                    places[item.element][item.id],
                    places["body"][item.body],
                    tuple(places["sensor"][sensor] for sensor in item.sensors),
                )
                for item in builder.objects.values()
            ],
            [builder.owner[body] for body in bodies],
            {kind: len(many) for kind, many in places.items()} | {"tendon": straight.tendons},
            builder.annotated_parents(),
            frozenset(
                place
                for body, place in places["body"].items()
                if model.body_parentid[body] not in places["body"] and _is_loose(model, body)
            ),
        )

    def fits(self, added: Addition, known: Annotations) -> bool:
        """Return whether each object gets a name, and is what the template says by that name's annotations.

        An object without annotations gets those that are left of a removed one of its name.
        """
        names = [
            added.names.get((item.element, added.prefix + item.element_name), "") for item in self.objects
        ]
        left = (
            known.objects[name] for name in names if name not in added.annotations and name in known.objects
        )
        return all(names) and all(notes.keys() <= {"shape"} for notes in left)


def template_of(
    spec: mujoco.MjSpec,
    names: Mapping[Element, str],
    annotations: Mapping[str, dict[str, Annotation]],
    hidden: Collection[str] = (),
) -> Template | None:
    """Return the objects of a spec that is added to a scene; None if it cannot be added so.

    Args:
        spec: the spec.
        names: names of the objects.
        annotations: annotations by these names.
        hidden: names of bodies that are not objects.
    """
    try:
        model = compile_spec(spec, logging.DEBUG)
    except (ValueError, mujoco.FatalError, SceneError):
        return None  # the compile of the scene has the error's text
    return Template.of_spec(model, names, annotations, hidden)


class _OfCopies(Builder):
    """Make the objects of some bodies of a model."""

    def __init__(
        self,
        model: mujoco.MjModel,
        straight: Straight,
        bodies: Sequence[int],
        names: Mapping[Element, str],
        annotations: Mapping[str, dict[str, Annotation]],
        hidden: Collection[str],
    ) -> None:
        super().__init__(model, replace(Annotations(), objects=annotations), hidden, names)
        self._straight, self._bodies = straight, bodies

    @cached_property
    def _leaves(self) -> dict[str, dict[int, list[int]]]:
        return {element: self._copied(element) for element in IN_BODIES}

    def _copied(self, element: str) -> dict[int, list[int]]:
        """Return the ids of the joints, sites, cameras or lights that are copied, by body."""
        bodies = getattr(self.model, f"{IN_BODIES[element]}_bodyid")
        wanted = self._straight.leaves[element]
        found: dict[int, list[int]] = {}
        for each in np.flatnonzero(np.isin(bodies, self._bodies)).tolist() if wanted else ():
            if getattr(self.model, element)(each).name in wanted:
                found.setdefault(int(bodies[each]), []).append(each)
        return found


def _is_loose(model: mujoco.MjModel, body: int) -> bool:
    """Return whether no joint holds a body at the top."""
    return not model.body_jntnum[body] or free_joint(model, body) >= 0
