"""Annotations of a scene: `<custom>` elements with the prefix `simx` for all settings that MJCF lacks.

`<text name="simx:KIND:OBJECT" data="key=value key=value"/>`; `<numeric name="simx:time_step" data="0.05"/>`.
In a value `%20` stands for a space, see `texts/values.py`.
Scripts and old custom UIs have other forms, see `texts/scripts.py` and `texts/old_uis.py`.
GRAMMAR is the whole list of kinds and keys; all others are errors that name the element and the valid values.
"""

from __future__ import annotations

from .annotation import (
    PREFIX,
    Annotation,
    Annotations,
    SceneError,
    Value,
    numbers_of,
)
from .checks import DETECTABLE_KINDS
from .grammar import (
    BROUGHT,
    ENGINES,
    ENTITY_PREFIX,
    FREE,
    GRAMMAR,
    PASSING,
    REGISTERED,
    UNTAGGED,
    WORLD,
)
from .reading import VOLUMES, parse, read_annotations
from .references import check_objects
from .writing import write_annotations

__all__ = [
    "BROUGHT",
    "DETECTABLE_KINDS",
    "ENGINES",
    "ENTITY_PREFIX",
    "FREE",
    "GRAMMAR",
    "PASSING",
    "PREFIX",
    "REGISTERED",
    "UNTAGGED",
    "VOLUMES",
    "WORLD",
    "Annotation",
    "Annotations",
    "SceneError",
    "Value",
    "check_objects",
    "numbers_of",
    "parse",
    "read_annotations",
    "write_annotations",
]
