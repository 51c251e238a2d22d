"""Delete assets of a spec that no geom has any more; copies of an object share them."""

from __future__ import annotations

from typing import Any

from simx_server.scene.spec_elements import leaves_of


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
    for name in textures:
        if not any(name in list(other.textures) for other in spec.materials):
            spec.delete(spec.texture(name))
