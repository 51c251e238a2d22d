"""Read a file: bytes to the plain objects of `objects/`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from simx_server.scene.formats.annotations import SceneError

from .chunks import MARKERS, Body, Chunks, MissingRecord, heads, sections
from .container import unpack
from .decoding import joints, paths, sensors, settings
from .decoding.clouds import fill_cloud
from .decoding.colors import surface_of
from .decoding.common import custom_data, fill_common
from .decoding.context import Reading
from .decoding.meshes import read_pools
from .decoding.numbers import position_first
from .decoding.registered import (
    collection_of,
    ik_group_of,
    motion_planning_of,
    old_ui_of,
    pair_of,
    path_planning_of,
)
from .decoding.scripts import script_of
from .decoding.shapes import fill_shape
from .objects import (
    Camera,
    Dummy,
    ForceSensor,
    Graph,
    Joint,
    Light,
    OtherObject,
    Path,
    PointCloud,
    ProximitySensor,
    Script,
    Shape,
    VisionSensor,
    VrepFile,
    VrepObject,
)

MOST_OBJECTS = 100_000
"""Of one file; the largest scene seen has 1,049."""

Fill = Callable[[Any, Chunks, Reading], None]

OBJECTS: dict[str, tuple[Callable[[int], VrepObject], Fill]] = {
    "SHP": (lambda handle: Shape(handle=handle), fill_shape),
    "JNT": (lambda handle: Joint(handle=handle), joints.fill_joint),
    "DMY": (lambda handle: Dummy(handle=handle), joints.fill_dummy),
    "FSE": (lambda handle: ForceSensor(handle=handle), joints.fill_force_sensor),
    "RSN": (lambda handle: VisionSensor(handle=handle), sensors.fill_vision_sensor),
    "SNR": (lambda handle: ProximitySensor(handle=handle), sensors.fill_proximity_sensor),
    "CMA": (lambda handle: Camera(handle=handle), sensors.fill_camera),
    "LGT": (lambda handle: Light(handle=handle), sensors.fill_light),
    "PAT": (lambda handle: Path(handle=handle), paths.fill_path),
    "GRH": (lambda handle: Graph(handle=handle), paths.fill_graph),
    "OCT": (lambda handle: PointCloud(handle=handle, is_octree=True), fill_cloud),
    "PTC": (lambda handle: PointCloud(handle=handle), fill_cloud),
    "MIL": (lambda handle: OtherObject(handle=handle, kind="mill"), paths.fill_other),
    "MIR": (lambda handle: OtherObject(handle=handle, kind="mirror"), paths.fill_other),
    "SCT": (lambda handle: OtherObject(handle=handle, kind="script"), paths.fill_other),
    "MKR": (lambda handle: OtherObject(handle=handle, kind="marker"), paths.fill_other),
    "CSO": (lambda handle: OtherObject(handle=handle, kind="custom"), paths.fill_other),
}
"""By tag: a function that makes an object, and one that fills it from its own records."""

MOST_RECORDS = 1_000_000

TopLevel = tuple[str, int, int]
"""Tag of a record, start and end of its payload."""

WITHOUT_DEFAULTS = ("SHP", "JNT")
"""Objects that would be something else without a record that is needed."""

FIRST = ("VIN", "DMA", "TEX", "SET")
"""Records that objects refer to, and settings that others replace."""

WITHOUT_MEANING = ("GHO", "VEW", "ORD")
"""Records that the window of the simulator needs: recorded trails, views, the order of lists."""


def read_file(data: bytes, name: str) -> VrepFile:
    """Decode a scene (`.ttt`) or model (`.ttm`).

    Args:
        data: the whole file.
        name: the file's name, for messages.

    Raises:
        SceneError: the bytes are not such a file, or damaged; the text names the program that saved the file, the
            record and its place.
    """
    try:
        return _read(data, name)
    except SceneError as error:
        raise SceneError(f"'{name}' cannot be read: {error}") from None


def _read(data: bytes, name: str) -> VrepFile:
    header, content = unpack(data)
    body = Body(content, header.writer)
    file = VrepFile(
        name=name,
        serialization=header.serialization,
        program=header.program,
        revision=header.revision,
        notes=body.notes,
    )
    top = _top_level(body)
    file.is_model = (
        header.is_model if header.is_model is not None else not any(tag == "SIM" for tag, _, _ in top)
    )
    reading, skipped = Reading(), Counter[str]()
    for place in top:
        if place[0] in FIRST:
            with body.tolerant("left out"):
                _read_first(file, reading, body, place)
    for place in top:
        tag, start, end = place
        if tag in OBJECTS:
            _read_object(file, reading, body, place)
        elif tag in REST:
            (chunks,) = sections(body, [REST[tag][0]], start, end, owner=tag)
            with body.tolerant("left out", SceneError if tag == USER_INTERFACE else MissingRecord):
                REST[tag][1](file, chunks)
        elif tag not in (*FIRST, *WITHOUT_MEANING):
            skipped[tag] += 1
    file.skipped = dict(skipped)
    _check_tree(file, body)
    for script in file.scripts:
        _assign(script, file)
    for item in file.objects.values():
        if isinstance(item, Joint):
            joints.choose_pid(item, file.settings.engine)
    return file


def _top_level(body: Body) -> list[TopLevel]:
    """Return tag and place of all records of the file, up to EOF, which must be its end."""
    found: list[TopLevel] = []
    for tag, start, end in heads(body, 0, len(body.data)):
        if tag == b"EOF":
            if end != len(body.data):
                raise body.error(end, f"{len(body.data) - end} bytes follow the end mark")
            return found
        if tag in MARKERS:
            raise body.error(start, f"the mark {tag!r} stands outside of all records")
        if len(found) >= MOST_RECORDS:
            raise body.error(start, f"the file has more than {MOST_RECORDS} records")
        found.append((tag.decode("latin-1"), start, end))
    raise body.error(len(body.data), "the end mark 'EOF' is missing")


def _read_first(file: VrepFile, reading: Reading, body: Body, place: TopLevel) -> None:
    tag, start, end = place
    (chunks,) = sections(body, ["surface" if tag == "DMA" else tag], start, end, owner=tag)
    if tag == "VIN":
        reading.pools = read_pools(chunks)
    elif tag == "DMA":
        (number,) = chunks.ints("Ipa", -1)
        reading.surfaces[number] = surface_of(chunks)
    elif tag == "SET":
        (file.settings.visible_layers,) = chunks.ints("Al2", file.settings.visible_layers)
    else:
        texture = settings.texture_of(chunks)
        file.textures[texture.id] = texture


def _read_object(file: VrepFile, reading: Reading, body: Body, place: TopLevel) -> None:
    tag, start, end = place
    common, own = sections(body, ["object", tag], start, end, owner=tag)
    handle, parent = common.ints("Ids")
    if handle < 0 or handle in file.objects:
        raise common.error(
            "Ids",
            f"has the handle {handle}, which " + ("is negative" if handle < 0 else "another object has"),
        )
    make, fill = OBJECTS[tag]
    item = make(handle)
    item.parent = parent
    common.owner = own.owner = f"object {handle} ({tag})"
    fill_common(item, common)
    if tag in WITHOUT_DEFAULTS:
        fill(item, own, reading)
    else:
        with body.tolerant("defaults are taken"):
            fill(item, own, reading)
    file.objects[handle] = item
    if len(file.objects) > MOST_OBJECTS:
        raise common.error("Ids", f"is that of one object too many: a file may have {MOST_OBJECTS}")
    for each in own.each("Soo") if tag == "SCT" else ():
        with body.tolerant("left out"):
            script = script_of(each, file.program)
            script.object, script.owner = handle, parent
            file.scripts.append(script)


def _read_script(file: VrepFile, chunks: Chunks) -> None:
    file.scripts.append(script_of(chunks, file.program))


def _read_thumbnail(file: VrepFile, chunks: Chunks) -> None:
    file.thumbnail = settings.thumbnail_of(chunks)


def _read_model(file: VrepFile, chunks: Chunks) -> None:
    if chunks.has("Mo2"):
        file.model_pose = position_first(chunks, "Mo2")
        file.bounds = chunks.reals("Mo2")[7:10]


USER_INTERFACE = "BBK"
"""Tag of an old user interface: a scene simulates as well without one."""

REST: dict[str, tuple[str, Callable[[VrepFile, Chunks], object]]] = {
    "LST": ("script", _read_script),
    "SIM": ("SIM", lambda file, chunks: settings.fill_simulation(file.settings, chunks)),
    "DYN": ("DYN", lambda file, chunks: settings.fill_dynamics(file.settings, chunks)),
    "ENV": ("ENV", lambda file, chunks: settings.fill_environment(file.settings, chunks)),
    "GRP": ("GRP", lambda file, chunks: file.collections.append(collection_of(chunks))),
    "COL": ("COL", lambda file, chunks: file.collisions.append(pair_of(chunks))),
    "DST": ("DST", lambda file, chunks: file.distances.append(pair_of(chunks))),
    "IKO": ("IKO", lambda file, chunks: file.ik_groups.append(ik_group_of(chunks))),
    "PPL": ("PPL", lambda file, chunks: file.path_plannings.append(path_planning_of(chunks))),
    "MPL": ("MPL", lambda file, chunks: file.motion_plannings.append(motion_planning_of(chunks))),
    USER_INTERFACE: ("BBK", lambda file, chunks: file.uis.append(old_ui_of(chunks))),
    "CDA": ("CDA", lambda file, chunks: file.custom_data.update(custom_data(chunks))),
    "CDS": ("CDS", lambda file, chunks: file.custom_data.update(custom_data(chunks))),
    "MTC": ("MTC", _read_thumbnail),
    "BBC": ("BBC", _read_model),
}
"""By tag: the list of records, and a function that takes over its content."""


def _check_tree(file: VrepFile, body: Body) -> None:
    """Check that each object's ancestors are there, and end."""
    safe: set[int] = {-1}
    for handle in file.objects:
        way: list[int] = []
        while handle not in safe:
            if handle not in file.objects:
                raise body.error(0, f"object {way[-1]} has the parent {handle}, which is not in the file")
            if len(way) > len(file.objects):
                raise body.error(0, f"object {way[0]} is among its own ancestors")
            way.append(handle)
            handle = file.objects[handle].parent
        safe.update(way)


def _assign(script: Script, file: VrepFile) -> None:
    """Drop the owner of a script where no object has that handle."""
    if script.owner not in file.objects:
        script.owner = -1
