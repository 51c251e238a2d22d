"""Recognise V-REP's files among those that are opened.

A file is V-REP's by its first bytes, whatever its name. A file that is called `.ttt` or `.ttm` goes to the same reader,
whose error describes what it is instead; unless the server has saved it (`archives`).
"""

from __future__ import annotations

import io
from pathlib import Path
from xml.etree import ElementTree

from simx_client.protocol.files import is_vrep_name
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.archives.archive import START, is_archive

_SIGNATURE = b"VREP"
_XML_ROOT = "CoppeliaSim"


def is_vrep(data: bytes, name: str) -> bool:
    """Return whether a file is read as V-REP's, by its bytes or by its name."""
    return data.startswith(_SIGNATURE) or (is_vrep_name(name) and not is_archive(data))


def is_vrep_file(file: Path) -> bool:
    """Return whether a file of the disk is read as V-REP's; one that cannot be read is, by its name."""
    try:
        with file.open("rb") as opened:
            return is_vrep(opened.read(START), file.name)
    except OSError:
        return is_vrep_name(file.name)


def refuse_xml(data: bytes, name: str) -> None:
    """Refuse CoppeliaSim's XML files, by their root element. Raises SceneError."""
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(data), events=("start",)):
            if element.tag == _XML_ROOT:
                raise SceneError(
                    f"'{name}' is in CoppeliaSim's XML format, which is not read; open it in CoppeliaSim, save it as "
                    "a .ttt scene or a .ttm model, and open that"
                )
            return
    except (ElementTree.ParseError, ValueError, LookupError):
        return  # the reader reports the error
