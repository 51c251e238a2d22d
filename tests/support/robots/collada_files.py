"""Small COLLADA files: a tetrahedron of two materials, with a unit, an up axis and an image."""

from __future__ import annotations

RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.5)

_EFFECT = """
<effect id="{name}-effect"><profile_COMMON>{surface}<technique sid="common"><phong>
 <diffuse>{diffuse}</diffuse><specular><color>0.2 0.4 0.6 1</color></specular>
</phong></technique></profile_COMMON></effect>"""

_SURFACE = """
<newparam sid="{image}-surface"><surface type="2D"><init_from>{image}</init_from></surface></newparam>
<newparam sid="{image}-sampler"><sampler2D><source>{image}-surface</source></sampler2D></newparam>"""

_TRIANGLES = """
<triangles material="{name}" count="2">
 <input semantic="VERTEX" source="#mesh-vertices" offset="0"/>
 <input semantic="TEXCOORD" source="#mesh-map" offset="1" set="0"/>
 <p>{indices}</p>
</triangles>"""


def collada(
    *,
    unit: float = 1.0,
    up: str = "Z_UP",
    image: str = "",
    matrix: str = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",
    materials: tuple[str, str] = ("red", "blue"),
    head: str = "",
    points: str = "0 0 0 1 0 0 0 1 0 0 0 1",
) -> str:
    """Return a tetrahedron whose first two triangles are red, or have an image, and whose others are blue.

    Args:
        unit: metres.
        up: the up axis.
        image: file of an image on the first two triangles.
        matrix: of the node that holds the mesh.
        materials: names of the materials that the mesh uses.
        head: text before the root element.
        points: x, y, z of each corner.
    """
    color = "<color>{} {} {} {}</color>"
    first = f'<texture texture="{"picture"}-sampler" texcoord="UVSET0"/>' if image else color.format(*RED)
    effects = _EFFECT.format(
        name="red", diffuse=first, surface=_SURFACE.format(image="picture") if image else ""
    ) + _EFFECT.format(name="blue", diffuse=color.format(*BLUE), surface="")
    images = f'<library_images><image id="picture"><init_from>{image}</init_from></image></library_images>'
    listed = "".join(
        f'<material id="{name}-material"><instance_effect url="#{name}-effect"/></material>'
        for name in ("red", "blue")
    )
    bound = "".join(f'<instance_material symbol="{name}" target="#{name}-material"/>' for name in materials)
    numbers = "0 0 1 0 1 1 0 1"
    triangles = _TRIANGLES.format(name=materials[0], indices="0 0 2 1 1 2 0 0 1 1 3 3") + _TRIANGLES.format(
        name=materials[1], indices="0 0 3 1 2 2 1 0 2 1 3 3"
    )
    return f"""<?xml version="1.0"?>{head}
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
 <unit meter="{unit}" name="unit"/><up_axis>{up}</up_axis></asset>
{images if image else ""}
<library_effects>{effects}</library_effects>
<library_materials>{listed}</library_materials>
<library_geometries><geometry id="mesh"><mesh>
 <source id="mesh-points"><float_array id="mesh-array" count="12">{points}</float_array>
  <technique_common><accessor source="#mesh-array" count="4" stride="3">
   <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
  </accessor></technique_common></source>
 <source id="mesh-map"><float_array id="map-array" count="8">{numbers}</float_array>
  <technique_common><accessor source="#map-array" count="4" stride="2">
   <param name="S" type="float"/><param name="T" type="float"/>
  </accessor></technique_common></source>
 <vertices id="mesh-vertices"><input semantic="POSITION" source="#mesh-points"/></vertices>
 {triangles}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="node"><matrix>{matrix}</matrix>
 <instance_geometry url="#mesh"><bind_material><technique_common>{bound}</technique_common></bind_material>
 </instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
"""


PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 4
property list uchar int vertex_indices
end_header
0 0 0 255 0 0
1 0 0 255 0 0
0 1 0 255 0 0
0 0 1 255 0 0
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
"""

TEXT_STL = (
    "solid t\n"
    + "".join(
        f"facet normal 0 0 0\nouter loop\n{''.join(f'vertex {corner}' + chr(10) for corner in face)}endloop\nendfacet\n"
        for face in (
            ("0 0 0", "0 1 0", "1 0 0"),
            ("0 0 0", "1 0 0", "0 0 1"),
            ("0 0 0", "0 0 1", "0 1 0"),
            ("1 0 0", "0 1 0", "0 0 1"),
        )
    )
    + "endsolid t\n"
)
