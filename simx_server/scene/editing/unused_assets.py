"""Delete assets of a spec that no geom has any more; copies of an object share them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.geometry.highlights import SPECULAR
from simx_server.scene.spec_elements import leaves_of


@dataclass(frozen=True)
class Assets:
    """Names of assets that some geoms have."""

    meshes: frozenset[str]
    fields: frozenset[str]
    materials: frozenset[str]

    @classmethod
    def of(cls, geoms: Iterable[Any]) -> Assets:
        """Return the assets of geoms of a spec."""
        names = [(geom.meshname, geom.hfieldname, geom.material) for geom in geoms]
        return cls(*(frozenset(each) - {""} for each in zip(*names, strict=True))) if names else cls._none()

    @classmethod
    def _none(cls) -> Assets:
        return cls(frozenset(), frozenset(), frozenset())

    def delete_unused(self, spec: Any) -> None:
        """Delete those that no geom has any more, with the textures of the materials and their highlights."""
        if not (self.meshes or self.fields or self.materials):
            return
        used = Assets.of(leaves_of(spec, "geoms"))
        for find, names in (
            (spec.mesh, self.meshes - used.meshes),
            (spec.hfield, self.fields - used.fields),
        ):
            for found in filter(None, map(find, sorted(names))):
                spec.delete(found)
        others = {each.material for many in (spec.tendons, spec.skins, spec.meshes) for each in many}
        for name in sorted(self.materials - used.materials - others):
            _delete_material(spec, name)


def _delete_material(spec: Any, name: str) -> None:
    material = spec.material(name)
    if material is None:
        return
    textures = [texture for texture in material.textures if texture]
    spec.delete(material)
    _delete_textures(spec, textures)
    if (highlight := spec.numeric(SPECULAR + name)) is not None:
        spec.delete(highlight)


def _delete_textures(spec: Any, names: Iterable[str]) -> None:
    """Delete textures that no material has any more."""
    for name in names:
        if not any(name in list(other.textures) for other in spec.materials):
            spec.delete(spec.texture(name))


def delete_unused(spec: Any, mesh: str, material: str, *, with_textures: bool) -> None:
    """Delete a mesh and a material, by name, if no geom has them.

    Args:
        spec: the spec.
        mesh: name, empty for none.
        material: name, empty for none.
        with_textures: also delete textures of the material that no other material has.
    """
    geoms = leaves_of(spec, "geoms")
    if mesh and not any(geom.meshname == mesh for geom in geoms):
        spec.delete(spec.mesh(mesh))
    if not material or any(geom.material == material for geom in geoms):
        return
    found = spec.material(material)
    textures = [name for name in found.textures if name] if with_textures else []
    spec.delete(found)
    _delete_textures(spec, textures)
