"""Check the names in annotations: objects, collections and other entries that must exist in the scene."""

from __future__ import annotations

from collections.abc import Collection

from simx_server.scene.formats.texts.graph_streams import (
    DISTANCE,
    MOST_STREAMS,
    USER,
    read_curves,
    read_streams,
)
from simx_server.scene.formats.texts.old_uis import UI_TEXT
from simx_server.scene.formats.texts.values import read_steps

from .annotation import PREFIX, Annotation, Annotations, SceneError
from .grammar import ENTITY_PREFIX, WORLD
from .ros2_keys import check_kind

_ALSO = {"vision": ("camera",), "shape": ("octree", "point cloud"), "cloud": ("octree",)}
"""Further kinds of objects that may have an annotation."""


_OF_TIPS = ("tip", "target", "base", "constraints", "precision", "weights", "axes", "active")
"""Keys of a group of inverse kinematics that have a value for each tip."""


def check_objects(annotations: Annotations, kinds_of: dict[str, str]) -> None:
    """Check that annotated objects exist and have the kind of their annotation. `kinds_of`: name to kind text."""
    needed = {
        "joint": "joint",
        "vision": "vision sensor",
        "camera": "camera",
        "dummy": "dummy",
        "proximity": "proximity sensor",
        "force": "force sensor",
        "shape": "shape",
        "path": "path",
        "follow": "dummy",
        "cloud": "point cloud",
    }
    for name, by_kind in annotations.objects.items():
        for kind in by_kind:
            if name not in kinds_of:
                raise SceneError(
                    f"text '{PREFIX}{kind}:{name}' names no object of the scene; names are those of bodies, "
                    "joints, cameras, sites, lights and driven tendons"
                )
            wanted = needed.get(kind)
            if wanted is not None and kinds_of[name] not in (wanted, *_ALSO.get(kind, ())):
                raise SceneError(
                    f"text '{PREFIX}{kind}:{name}' is for a {wanted}, but '{name}' is a {kinds_of[name]}"
                )
            if kind == "ros2":
                check_kind(by_kind[kind], f"{PREFIX}ros2:{name}", kinds_of[name], kinds_of)
    _check_names(annotations, kinds_of)


def _check_names(annotations: Annotations, objects: Collection[str]) -> None:
    """Check that the objects named by collections, collision and distance objects and sensors exist."""
    collections = annotations.registered.get("collection", {})
    for name, note in collections.items():
        for key in ("objects", "tree", "below", "chain", "without"):
            for word in filter(None, str(note.get(key, "")).split(",")):
                _must_name(f"collection:{name}", key, word, objects, "object")
        for _, kind, word in read_steps(str(note.get("steps", ""))):
            if kind != "all":
                _must_name(f"collection:{name}", "steps", word, objects, "object")
    entities = {"all", *objects, *collections, *(f"{ENTITY_PREFIX}{name}" for name in collections)}
    for kind in ("collision", "distance"):
        for name, note in annotations.registered.get(kind, {}).items():
            for key in ("entity1", "entity2"):
                _must_name(f"{kind}:{name}", key, str(note.get(key, "all")), entities, "object or collection")
            if note.get("entity1", "all") == "all":
                raise SceneError(f"text '{PREFIX}{kind}:{name}' needs entity1=, an object or collection")
    groups = annotations.registered.get("ik", {})
    for name, note in groups.items():
        _check_group(f"ik:{name}", note, objects)
        if "after" in note:
            _must_name(f"ik:{name}", "after", str(note["after"]), groups, "group of inverse kinematics")
    _check_plannings(annotations, objects, entities)
    _check_motion_plannings(annotations, objects, entities)
    _check_references(annotations, objects, entities)


def _check_plannings(annotations: Annotations, objects: Collection[str], entities: Collection[str]) -> None:
    """Check that the objects and entities of path planning tasks exist."""
    for name, note in annotations.registered.get("planning", {}).items():
        for key in ("path", "start", "goal"):
            _must_name(f"planning:{name}", key, str(note.get(key, "")), objects, "object")
        for key in ("robot", "obstacles"):
            _must_name(f"planning:{name}", key, str(note.get(key, "all")), entities, "object or collection")


def _check_motion_plannings(
    annotations: Annotations, objects: Collection[str], entities: Collection[str]
) -> None:
    """Check that the joints, groups and entities of motion planning tasks exist."""
    groups = annotations.registered.get("ik", {})
    for name, note in annotations.registered.get("motion_planning", {}).items():
        element = f"motion_planning:{name}"
        for word in str(note.get("joints", "")).split(","):
            _must_name(element, "joints", word, objects, "object")
        _must_name(element, "ik", str(note.get("ik", "")), groups, "group of inverse kinematics")
        for key in ("robot", "obstacles", "own", "own_others"):
            _must_name(element, key, str(note.get(key, "all")), entities, "object or collection")


def _check_references(annotations: Annotations, objects: Collection[str], entities: Collection[str]) -> None:
    """Check that the parents and entities of single objects and the objects of UIs exist."""
    for name, note in annotations.registered.get(UI_TEXT, {}).items():
        if "object" in note:
            _must_name(f"{UI_TEXT}:{name}", "object", str(note["object"]), objects, "object")
    for name, by_kind in annotations.objects.items():
        parent = by_kind.get("object", {}).get("parent")
        if parent is not None and parent != "world":
            _must_name(f"object:{name}", "parent", str(parent), objects, "object")
        linked = by_kind.get("dummy", {}).get("linked")
        if linked is not None:
            _must_name(f"dummy:{name}", "linked", str(linked), objects, "object")
        for kind in ("proximity", "vision"):
            word = str(by_kind.get(kind, {}).get("entity", "all"))
            _must_name(f"{kind}:{name}", "entity", word, entities, "object or collection")
        if "graph" in by_kind:
            distances = annotations.registered.get("distance", {})
            _check_graph(f"graph:{name}", by_kind["graph"], objects, distances)


def _check_graph(
    element: str, note: Annotation, objects: Collection[str], distances: Collection[str]
) -> None:
    """Check that what a graph's streams measure exists, and the streams of its curves."""
    streams = read_streams(str(note.get("streams", "")))
    for stream in streams:
        if stream.measures == DISTANCE:
            _must_name(element, "streams", stream.object, distances, "distance object")
        elif stream.measures != USER:
            _must_name(element, "streams", stream.object, objects, "object")
    known = {stream.name for stream in streams}
    curves = read_curves(str(note.get("curves", "")))
    if len(streams) + len(curves) > MOST_STREAMS:
        raise SceneError(
            f"text '{PREFIX}{element}' has {len(streams)} streams and {len(curves)} curves; "
            f"valid are {MOST_STREAMS} in all"
        )
    for curve in curves:
        for name in curve.streams:
            _must_name(element, "curves", name, known, "stream of this graph")


def _check_group(element: str, note: Annotation, objects: Collection[str]) -> None:
    """Check the objects of an inverse kinematics group, and that each key has one value or one for each tip."""
    if not note.keys() & _OF_TIPS:
        return  # it has no tips yet
    tips = str(note.get("tip", "")).split(";")
    for key in _OF_TIPS:
        words = str(note.get(key, "")).split(";")
        if key in ("tip", "target") or (key in ("base", "axes") and key in note):
            for word in words:
                if key == "tip" or word != WORLD:
                    _must_name(element, key, word, objects, "object")
        if len(words) not in (1, len(tips)) or (key == "target" and len(words) != len(tips)):
            raise SceneError(
                f"text '{PREFIX}{element}' has {len(tips)} in tip= and {len(words)} in {key}=; "
                "give as many with semicolons between them"
            )


def _must_name(element: str, key: str, word: str, known: Collection[str], what: str) -> None:
    if word not in known:
        raise SceneError(f"text '{PREFIX}{element}' has {key}={word}, which is no {what} of the scene")
