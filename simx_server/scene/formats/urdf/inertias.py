"""Repair masses and inertias of a URDF that MuJoCo refuses."""

from __future__ import annotations

import logging
from xml.etree import ElementTree

import numpy as np

from .names import some
from .numbers import number

logger = logging.getLogger(__name__)

_LEAST_INERTIA = 0.001
"""Inertia in kg m^2 that replaces an inertia of zeros, as in V-REP's importer."""

_MOMENTS = ("ixx", "iyy", "izz")
_PRODUCTS = ("ixy", "ixz", "iyz")

_NOTHING = 1e-12
"""kg m^2: programs write such numbers for zero."""

_TINY = 1e-6
"""Smallest principal moment, as a share of the largest one, of an inertia that a body can have."""


def repair_inertias(root: ElementTree.Element) -> None:
    """Repair inertias.

    As in V-REP an invalid mass counts as not given, and an inertia of zeros becomes a small one. Of an inertia
    that no body can have the products are left out, and moments that are not positive.
    """
    zeros: list[str] = []
    impossible: list[str] = []
    for link in root.iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is None or _written(mass.get("value")) <= 0:
            link.remove(inertial)
            continue
        if inertia is None:
            inertia = ElementTree.SubElement(inertial, "inertia")
        moments = [_written(inertia.get(key)) for key in _MOMENTS]
        if max(moments) < _NOTHING:
            zeros.append(link.get("name", ""))
            _write(inertia, _MOMENTS, str(_LEAST_INERTIA))
            _write(inertia, _PRODUCTS, "0")
        elif not _is_possible(inertia):
            impossible.append(link.get("name", ""))
            _write(inertia, _PRODUCTS, "0")
            for key, moment in zip(_MOMENTS, moments, strict=True):
                inertia.set(key, str(moment if moment > _TINY * max(moments) else max(moments)))
        else:
            for key in _PRODUCTS:
                inertia.set(key, inertia.get(key, "0"))
    if zeros:
        logger.warning("the inertia of %s is zero; it is %s kg m^2 now", some(zeros), _LEAST_INERTIA)
    if impossible:
        logger.warning(
            "no body has the inertia of %s; its products are left out, and moments of zero", some(impossible)
        )


def _write(inertia: ElementTree.Element, keys: tuple[str, ...], value: str) -> None:
    for key in keys:
        inertia.set(key, value)


def _is_possible(inertia: ElementTree.Element) -> bool:
    """Return whether the principal moments are positive."""
    xx, yy, zz, xy, xz, yz = (number(inertia.get(key), 0.0) for key in (*_MOMENTS, *_PRODUCTS))
    moments = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    return bool(moments[0] > _TINY * moments[-1])


def _written(text: str | None) -> float:
    """Return a number; 1 for another text, which MuJoCo reports, and 0 for none."""
    try:
        return float(text or 0)
    except ValueError:
        return 1.0
