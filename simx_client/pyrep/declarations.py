"""The one structure of the C library that cffi has to know; `python -m simx_client.pyrep.declarations` writes `_ffi`.

The generated module imports in less than a millisecond; declarations that are read at each start take 40.
"""

from __future__ import annotations

from pathlib import Path

DECLARATIONS = """
struct SShapeVizInfo
{
    float *vertices;
    int verticesSize;
    int *indices;
    int indicesSize;
    float shadingAngle;
    float *normals;
    float colors[9];
    char *texture;
    int textureId;
    int textureRes[2];
    float *textureCoords;
    int textureApplyMode;
    int textureOptions;
};
"""


def write(path: Path) -> None:
    """Write the module that makes the structure known. Needs cffi's C parser."""
    from cffi import FFI

    maker = FFI()
    maker.cdef(DECLARATIONS)
    maker.set_source("simx_client.pyrep._ffi", None)
    maker.emit_python_code(str(path))


if __name__ == "__main__":
    write(Path(__file__).with_name("_ffi.py"))
