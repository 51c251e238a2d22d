"""Writes V-REP's own files, so that tests have scenes and models of any kind and version.

    writer = VrepWriter(ser=25)
    base = writer.shape("base", cuboid=(0.2, 0.2, 0.1), mass=2.0, dynamic=True, respondable=True, model_base=True)
    motor = writer.joint("motor", parent=base, position=(0, 0.1, 0), motor=True, target_velocity=1.5, max_force=10)
    writer.shape("wheel", parent=motor, cylinder=(0.1, 0.1, 0.02), dynamic=True, respondable=True)
    writer.script("function sysCall_init() end", base)
    writer.settings(time_step=0.01, engine=0)
    data = writer.bytes()

Each method that makes an object returns its handle, and takes what all objects have: parent, position, quaternion
(w, x, y, z), alias, layers, properties, model_base, model_properties, order, acknowledgement, custom_data,
parameters, references, `extra` (records that are written as they are, after NXT). `ser` 16 to 25 chooses tags and
number formats of that version.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from vrep_clouds import octree_cells, point_cells
from vrep_meshes import mesh_of, normals_of
from vrep_packing import (
    Tree,
    array,
    chunk,
    compress,
    header,
    listed,
    masked,
    numbers,
    packed_indices,
    packed_normals,
    text,
)
from vrep_rest import RestOfFile, Triple

PROGRAMS = {
    16: (3, 0, 3), 17: (3, 1, 2), 18: (3, 3, 0), 20: (3, 4, 0), 21: (3, 5, 0), 22: (4, 1, 0), 23: (4, 3, 0),
    24: (4, 5, 0), 25: (4, 7, 0),
}  # fmt: skip
"""A program that wrote each version of the format."""

PRIMITIVES = ("mesh", "plane", "disc", "cuboid", "spheroid", "cylinder", "cone", "heightfield", "capsule")
JOINTS = {"revolute": 10, "prismatic": 11, "spherical": 12}
MODES = {"passive": 0, "motion": 1, "ik": 2, "dependent": 4, "force": 5}
CONTROLS = {"velocity": 4, "position": 8, "spring": 12, "script": 16, "force": 1}
VOLUMES = ("pyramid", "cylinder", "disc", "cone", "ray")
SCRIPTS = {"main": 0, "child": 1, "contact": 5, "customization": 6}


class VrepWriter(RestOfFile):
    """One file in the making."""

    def __init__(
        self,
        ser: int = 21,
        program: tuple[int, int, int] | None = None,
        *,
        is_model: bool = False,
        **header: Any,
    ) -> None:
        """Start a file; `header` may have revision."""
        super().__init__(ser, program or PROGRAMS[ser])
        self.is_model = is_model
        self._header = header
        self._pools: dict[str, list[bytes]] = {"Ver": [], "Ind": [], "Nor": []}
        self._handles = self._scripts = 0

    # What the file consists of.

    def body(self) -> bytes:
        """Return the uncompressed body."""
        pools = b""
        if self.ser >= 18:
            names = ("Ver", "In2", "No2") if self.ser < 24 else ("Ver", "Ind", "Nor")
            pool = zip(names, self._pools.values(), strict=True)
            pools = listed("VIN", *(chunk(tag, data) for tag, items in pool for data in items))
        return pools + b"".join(self.records) + b"EOF"

    def bytes(self, *, compression: int = 1, tree: Tree | None = None) -> bytes:
        """Return the file."""
        body = self.body()
        kind = 0 if self.program < (3, 6, 1) else 2 if self.is_model else 1
        start = header(
            body,
            serialization=self.ser,
            program=self.program,
            compression=compression,
            kind=kind,
            **self._header,
        )
        return start + (compress(body, tree) if compression else body)

    # Objects.

    def shape(
        self,
        name: str,
        *,
        leaves: Sequence[Mapping[str, Any]] = (),
        mass: float = 1.0,
        inertia: Triple = (0.01, 0.01, 0.01),
        center: Triple = (0.0, 0.0, 0.0),
        dynamic: bool = False,
        respondable: bool = False,
        asleep: bool = False,
        mask: int = 0xFFFF,
        velocity: Sequence[float] = (0.0,) * 6,
        friction: float | None = None,
        material: Mapping[str, tuple[Sequence[float], Sequence[int]]] | None = None,
        **rest: Any,
    ) -> int:
        """Add a shape: of one leaf, given by a primitive's name and size (cuboid=(x, y, z)) or mesh=(vertices,
        triangles), or a group of `leaves`, mappings with the same keys.

        Leaf keys besides: color, color_name, opacity, texture (id), texture_scale, texture_coordinates (u, v of each
        corner), heights ((rows, columns)), pose ((position, quaternion)), wireframe, convex, culled. `inertia` is
        divided by the mass. `material`: engine's tag to its numbers, as (reals, ints).
        """
        leaf_keys = {key: rest.pop(key) for key in [*rest] if key in (*PRIMITIVES, *_LEAF_KEYS)}
        single = [] if leaves else [leaf_keys]
        material_id, surface = self._surface(friction, material)
        wrapper = self._numbers("Mas", "r", mass) + self._numbers("Ine", "10r", *center, 1, 0, 0, 0, *inertia)
        wrapper = chunk("Nme", text("part")) + wrapper + self._numbers("Dmi", "i", material_id)
        if leaves:
            inside = b"".join(chunk("Geo", wrapper + b"EOO" + self._leaf(leaf)) for leaf in leaves)
            geometry = chunk("Gsg", wrapper + self._numbers("Var", "B", 0) + inside + b"EOO")
        else:
            convex = 4 if single[0].get("convex") else 0
            geometry = chunk(
                "Gst", wrapper + self._numbers("Var", "B", convex) + b"EOO" + self._leaf(single[0])
            )
        own = chunk("Ge2", geometry + b"EOO")
        own += surface if self.ser >= 20 else b""
        own += self._numbers("Dc2", "H", mask) + self._numbers("Idv", "6r", *velocity)
        own += self._numbers("Sss", "B", 128 * dynamic + 64 * asleep)
        own += self._numbers("Ss3" if self.ser >= 18 else "Ss2", "B", int(respondable))
        if surface and self.ser < 20:
            self.records.append(b"DMA" + surface[3:])
        return self._object("SHP", name, own, rest)

    def joint(
        self,
        name: str,
        *,
        kind: str = "revolute",
        at: float = 0.0,
        turn: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        pitch: float = 0.0,
        limits: tuple[float, float] | None = (-1.5, 1.5),
        mode: str = "force",
        hybrid: bool = False,
        motor: bool = False,
        control: str = "velocity",
        lock: bool = False,
        target_velocity: float = 0.0,
        max_force: float = 100.0,
        target_position: float = 0.0,
        upper_velocity: float = 6.0,
        pid: Triple = (0.1, 0.0, 0.0),
        spring: tuple[float, float] = (0.1, 0.0),
        master: tuple[int, float, float] = (-1, 1.0, 0.0),
        engines: Mapping[str, tuple[Sequence[float], Sequence[int]]] | None = None,
        **rest: Any,
    ) -> int:
        """Add a joint: `at` is its position, `limits` None makes it cyclic, `master` is (handle, factor, offset)."""
        low, high = limits or (-3.14159, 3.14159)
        flags = (limits is None) + 16 * motor + 64 * hybrid
        flags += 32 * (control in ("position", "spring")) + 128 * (control == "spring")
        own = self._numbers("Jtt", "i", JOINTS[kind]) + self._numbers("Jsp", "r", pitch)
        own += self._numbers("Jst", "4r", *turn) + self._numbers("Va9", "B", flags)
        own += self._numbers("Vaa", "B", 2 * lock) + self._numbers("Pmr", "2r", low, high - low)
        own += self._numbers("Prt", "r", at) + self._numbers("Jmd", "i", MODES[mode])
        own += self._numbers("Jdt", "i2r", *master) + self._numbers("Dmp", "2r", target_velocity, max_force)
        own += self._numbers("Spp", "2r", *spring) + self._numbers("Dtp", "r", target_position)
        own += self._numbers("Arg", "2r", 0.1, 0.02)
        if self.ser < 25:
            own += self._numbers("Dp2", "3f", *pid) + self._numbers("Ulv", "f", upper_velocity)
        if self.ser >= 23 and self.program >= (4, 3, 0):
            own += self._numbers("Ruc", "3r", upper_velocity, 10, 10)
            own += self._numbers("Dcm", "i", CONTROLS[control] if motor else 0)
        if engines is None and self.ser >= 24:
            bullet = ((0.2, 0, 0, 0, 0, *pid), (0,))
            engines = {"BtN": bullet, "OdN": bullet, "Mj3": ((0.0,) * 27 + tuple(pid), (0, 0))}
        for tag, (reals, ints) in (engines or {}).items():
            own += array(tag, reals, ints, self.ser)
        return self._object("JNT", name, own, rest)

    def dummy(
        self, name: str, *, linked: int = -1, link_type: int = 0, size: float = 0.01,
        path_offset: float | None = None, **rest: Any,
    ) -> int:  # fmt: skip
        """Add a dummy. The linked one may be added later: handles count from 0. `path_offset`: on its parent path."""
        own = self._numbers("Dy2", "r", size) + _color((0.0, 0.5, 1.0), self.ser)
        own += self._numbers("Lli", "i", linked) + self._numbers("Dl2", "i", link_type)
        own += self._numbers("Var", "B", 2 * (path_offset is not None))
        own += self._numbers("Po5", "2r", path_offset or 0.0, 0.0)
        return self._object("DMY", name, own, rest)

    def force_sensor(
        self, name: str, *, force: float | None = None, torque: float | None = None, violations: int = 1,
        samples: int = 1, median: bool = False, **rest: Any,
    ) -> int:  # fmt: skip
        """Add a force sensor that breaks beyond a force or torque."""
        tag, form = ("Tri", "2ri") if self.program >= (4, 0, 0) else ("Tre", "2fi")
        own = self._numbers(tag, form, force or 100.0, torque or 10.0, violations)
        own += self._numbers("Vab", "B", (force is not None) + 2 * (torque is not None))
        own += self._numbers("Fil", "2i", samples, int(median)) + self._numbers("Siz", "r", 0.05)
        return self._object("FSE", name, own, rest)

    def vision_sensor(
        self, name: str, *, resolution: tuple[int, int] = (64, 64), perspective: bool = True, angle: float = 1.0,
        orthographic_size: float = 1.0, near: float = 0.01, far: float = 5.0, explicit: bool = False,
        flags: int = 0, entity: int = -1, filters: Sequence[Mapping[str, Any]] | None = None, **rest: Any,
    ) -> int:  # fmt: skip
        """Add a vision sensor; a filter has type, and perhaps enabled, ints, reals, data."""
        own = self._numbers("Ccp", "4r", orthographic_size, angle, near, far)
        own += self._numbers("Res", "2i", *resolution) + self._numbers("Dox", "i", entity)
        own += self._numbers("Va3", "B", perspective + 2 * explicit) + self._numbers("Va2", "B", flags)
        own += (
            self._numbers("Si2", "r", 0.05)
            if self.ser >= 24
            else self._numbers("Siz", "3f", 0.05, 0.05, 0.05)
        )
        own += self._numbers("Db2", "3f", 0.1, 0.2, 0.3) + self._numbers("Rmd", "i", 0)
        if filters is not None and self.program < (4, 0, 0):
            own += listed("Cfr", *(self._filter(each) for each in filters))
        return self._object("RSN", name, own, rest)

    def proximity_sensor(
        self, name: str, *, volume: str = "ray", method: str = "", sizes: Sequence[float] = (0.0, 1.0) + (0.0,) * 7,
        gap: float = 0.0, minimum: float | None = None, closest: bool = True, explicit: bool = False,
        max_angle: float | None = None, entity: int = -1, faces: tuple[bool, bool] = (True, True), **rest: Any,
    ) -> int:  # fmt: skip
        """Add a proximity sensor.

        `sizes`: offset, range, x, y, x far, y far, radius, radius far, angle. `faces`: front, back.
        """
        inner = self._numbers("Snt", "i", VOLUMES.index(volume)) + self._numbers("Ss3", "9r", *sizes)
        inner += self._numbers("Ssi", "4i", 32, 1, 1, 16) + self._numbers(
            "Par", "B", int(minimum is not None)
        )
        inner += self._numbers("Wtf", "r", minimum or 0.0) + self._numbers("Sia", "r", gap)
        flags = 2 * closest + 4 * (max_angle is not None) + 16 * (not faces[0]) + 32 * (not faces[1])
        own = self._numbers("Snt", "i", 30 + VOLUMES.index(method or volume)) + listed("Vod", inner)
        own += self._numbers("Pr4", "B", flags + 128 * explicit) + self._numbers("Al2", "r", max_angle or 0.7)
        own += self._numbers("Sns", "r", 0.01) + self._numbers("Sox", "i", entity)
        own += self._numbers("Sst", "i", 0x10)
        return self._object("SNR", name, own, rest)

    def camera(
        self, name: str, *, angle: float = 1.0, near: float = 0.05, far: float = 30.0, **rest: Any
    ) -> int:
        """Add a camera with perspective."""
        own = self._numbers("Cp3", "2r", 2.0, angle) + self._numbers("Ccp", "2r", near, far)
        own += self._numbers("Cp4", "i1r", -1, 0.05) + self._numbers("Ca2", "B", 0)
        return self._object("CMA", name, own, rest)

    def light(
        self, name: str, *, kind: int = 3, color: Triple = (0.5, 0.5, 0.5), on: bool = True, **rest: Any
    ) -> int:
        """Add a light: 1 omnidirectional, 2 spot, 3 directional."""
        own = self._numbers("Cp2", "2i1r", kind, 20, 0.1) + self._numbers("Cp3", "r", 0.8)
        own += self._numbers("Caf", "3r", 1, 0, 0) + self._numbers("Cas", "B", int(on))
        own += _color((0, 0, 0), self.ser, tag="Cl2", light=color)
        return self._object("LGT", name, own, rest)

    def path(
        self,
        name: str,
        points: Sequence[Sequence[float]],
        *,
        closed: bool = False,
        bezier: int = 1,
        pauses: Sequence[float] = (),
        along: float = 0.0,
        velocity: float = 0.0,
        method: int = 5,
        attributes: int = 3,
        section: Sequence[tuple[float, float]] = (),
        scale: float = 1.0,
        color: Triple = (0.0, 0.0, 0.0),
        **rest: Any,
    ) -> int:
        """Add a path of points x, y, z, or x, y, z and a quaternion; `along`: its position; with a section it is
        drawn as a body too.
        """
        written = [self._numbers("At2", "i", attributes | 4 * closed)]
        written += [
            self._numbers("Jm2", "4f", along, velocity, 0, 0),
            self._numbers("Av3", "fi", 0.0637, method),
        ]
        for index, point in enumerate(points):
            pose = [*point, 1, 0, 0, 0][:7]
            records = self._numbers("At2", "9r1i1r", *pose, 0.5, 0.5, bezier, 1.0)
            records += self._numbers("At3", "f", pauses[index] if pauses else 0.0)
            if self.ser >= 20:
                records += chunk("At4", struct.pack("<H4f", index, 0, 0, 0, index))
            written.append(listed("Pat", records))
        own = self._numbers("Var", "B", int(bool(section))) + self._numbers("Pss", "f", scale)
        own += self._numbers("Sha", "fi", 0.005, 4) + listed("Ntp", *written)
        flat = [coordinate for corner in section for coordinate in corner]
        own += chunk("Sec", struct.pack(f"<i{len(flat)}f", len(flat), *flat))
        own += _color(color, self.ser, tag="Scl")
        return self._object("PAT", name, own, rest)

    def graph(self, name: str, streams: Sequence[tuple[str, int, int]] = (), **rest: Any) -> int:
        """Add a graph with streams of (name, kind, object)."""
        own = self._numbers("Gbv", "2i", 1000, 0)
        for number, (stream, kind, item) in enumerate(streams):
            records = chunk("Nme", text(stream)) + self._numbers("Oid", "i", number)
            records += self._numbers("Dt2", "3i", kind, item, -1) + self._numbers("Col", "3f", 1, 0, 0)
            own += listed("Ghd", records)
        return self._object("GRH", name, own, rest)

    def octree(
        self, name: str, middles: Sequence[Sequence[float]], edge: float = 0.1, rgb: tuple[int, int, int] = (255, 0, 0),
        **rest: Any,
    ) -> int:  # fmt: skip
        """Add an octree of cells with this edge; their middles are multiples of it plus a half."""
        own = self._numbers("Siz", "r1i", edge, 2) + chunk("Co2", octree_cells(middles, edge, rgb))
        return self._object("OCT", name, own, rest)

    def point_cloud(
        self,
        name: str,
        points: Sequence[Sequence[float]],
        rgb: tuple[int, int, int] = (255, 0, 0),
        **rest: Any,
    ) -> int:
        """Add a point cloud."""
        own = self._numbers("Siz", "r1i", 0.02, 2) + chunk("Co2", point_cells(points, rgb))
        return self._object("PTC", name, own, rest)

    def mill(self, name: str, **rest: Any) -> int:
        """Add a mill with a cylinder as volume."""
        inner = self._numbers("Snt", "i", 1)
        inner += self._numbers("Ss3", "9r", 0, 0.1, 0, 0, 0, 0, 0.05, 0.05, 0)
        return self._object("MIL", name, listed("Vod", inner), rest)

    def other(self, tag: str, name: str, own: bytes = b"", **rest: Any) -> int:
        """Add an object of any tag with these records after NXT."""
        return self._object(tag, name, own, rest)

    # The rest of a file.

    def script(
        self, code: str, owner: int = -1, *, kind: str = "child", threaded: bool = False, disabled: bool = False,
        language: str = "", parameters: Sequence[tuple[str, str, str]] = (), flags: int = 0, as_object: bool = False,
        unowned: bool = False, order: int | None = None, traversal: int | None = None,
    ) -> int:  # fmt: skip
        """Add a script of an object, or with -1 the main script; `as_object` hangs a script object below the owner.

        Returns the script's id, or the script object's handle.
        """
        self._scripts += 1
        handle = self._handles if as_object else owner
        number, kind_number = 247000 + self._scripts, SCRIPTS["main" if owner < 0 else kind]
        hidden = unowned and not as_object
        records = self._numbers("Si2", "3i", number, -1 if hidden else handle, kind_number)
        records += self._numbers("Coc", "i", handle) if not hidden else b""
        records += self._numbers("Va2", "B", threaded + 2 * disabled + flags) + chunk("Ste", masked(code))
        records += b"" if order is None else chunk("Seo", struct.pack("<i", order))
        records += b"" if traversal is None else chunk("Ttd", struct.pack("<i", traversal))
        records += chunk("Lne", text(language)) if language else b""
        records += _parameters("Prm", parameters)
        if as_object:
            return self._object("SCT", f"script{self._scripts}", listed("Soo", records), {"parent": owner})
        self.records.append(listed("LST", records))
        return number

    # How it is written.

    def _object(self, tag: str, name: str, own: bytes, common: dict[str, Any]) -> int:
        handle = common.pop("handle", self._handles)
        self._handles = max(self._handles, handle) + 1
        extra = common.pop("extra", b"")
        self.records.append(
            chunk(tag, self._common_part(handle, name, **common) + b"NXT" + own + extra + b"EOO")
        )
        return handle

    def _common_part(
        self, handle: int, name: str, *, parent: int = -1, position: Triple = (0.0, 0.0, 0.0),
        quaternion: Sequence[float] = (1.0, 0.0, 0.0, 0.0), alias: str | None = None, layers: int = 1,
        properties: int = 0x3F3, model_base: bool = False, model_properties: int | None = None, flags: int = 0,
        order: int = -1, acknowledgement: str = "", custom_data: Mapping[str, bytes] | None = None,
        parameters: Sequence[tuple[str, str, str]] = (), references: Mapping[str, Sequence[int]] | None = None,
    ) -> bytes:  # fmt: skip
        records = self._numbers("Ids", "2i", handle, parent) + chunk("Nme", text(name))
        records += self._numbers("Cfq", "7r", *quaternion, *position) + self._numbers("Lar", "H", layers)
        if self.program >= (4, 3, 0):
            records += chunk("Ali", text(name if alias is None else alias)) + self._numbers("Cor", "i", order)
        records += self._numbers("Omp", "i", properties) + self._numbers("Op2", "i", flags)
        model = (0 if model_base else 0xF000) if model_properties is None else model_properties
        records += self._numbers("Mpo", "i", model) + self._numbers("Sfa", "r", 1.0)
        flag_tag = "Var" if self.ser < 20 else "Va2" if self.ser < 21 else "Va3"
        records += self._numbers(flag_tag, "B", int(model_base)) + chunk("Ack", text(acknowledgement))
        if custom_data:
            tag, data = self._custom_data(custom_data)
            records += listed(tag, data)
        for tag, handles in (references or {}).items():
            count = struct.pack("<i", len(handles))
            if tag:
                records += chunk("Cr2", text(tag) + count + struct.pack(f"<{len(handles)}i", *handles))
            else:
                records += chunk(
                    "Crh", count + b"".join(struct.pack("<3i", 109, each, 0) for each in handles)
                )
        return records + _parameters("Lsp", parameters)

    def _surface(
        self, friction: float | None, material: Mapping[str, tuple[Sequence[float], Sequence[int]]] | None
    ) -> tuple[int, bytes]:
        if friction is None and material is None:
            return -1, b""
        engines = dict(material or {})
        if friction is not None:
            engines["BuN"] = ((0.0, friction, friction, 0.0, 0.0, 0.0, 0.0, 0.0), (0, 0))
        number = 2290000 + self._next_id()
        records = self._numbers("Ipa", "i", number) + chunk("Gon", text("material"))
        for tag, (reals, ints) in engines.items():
            records += array(tag, reals, ints, self.ser)
        return number, listed("Mat", records)

    def _filter(self, each: Mapping[str, Any]) -> bytes:
        records = self._numbers("Sft", "3i", each["type"], -1, -1)
        records += self._numbers("Sfe", "B", int(each.get("enabled", True)))
        if ints := each.get("ints"):
            records += chunk("Pai", struct.pack(f"<i{len(ints)}i", len(ints), *ints))
        if reals := each.get("reals"):
            records += chunk("Paf", struct.pack(f"<i{len(reals)}f", len(reals), *reals))
        if data := each.get("data"):
            records += chunk("Pab", struct.pack("<i", len(data)) + data)
        return listed("Sfr", records)

    def _leaf(self, leaf: Mapping[str, Any]) -> bytes:
        kind = next((each for each in PRIMITIVES if each in leaf), "cuboid")
        size = leaf.get(kind, (0.1, 0.1, 0.1)) if kind != "mesh" else (1.0, 1.0, 1.0)
        if kind == "mesh":
            vertices, triangles = (np.asarray(part) for part in leaf["mesh"])
        else:
            vertices, triangles = mesh_of("cuboid" if kind in ("heightfield", "capsule") else kind, size)
        position, turn = leaf.get("pose", ((0, 0, 0), (1, 0, 0, 0)))
        records = self._mesh(vertices, triangles)
        records += _color(
            leaf.get("color", (0.8, 0.8, 0.8)), self.ser, leaf.get("color_name", ""), leaf.get("opacity", 1.0)
        )
        records += self._numbers("Ppr", "i3r", PRIMITIVES.index(kind), *size)
        records += self._numbers("Ppf", "7r", *position, *turn) + self._numbers("Gsa", "r1i", 0.35, 1)
        records += self._numbers("Var", "B", 2 * bool(leaf.get("culled")) + 4 * bool(leaf.get("wireframe")))
        records += self._numbers("Va2", "B", int(bool(leaf.get("convex")))) if self.ser >= 24 else b""
        if "texture" in leaf:
            u, v = leaf.get("texture_scale", (1.0, 1.0))
            use = self._numbers("Tob", "2i2r", leaf["texture"], 0, u, v) + self._numbers("Bst", "B", 13)
            if "texture_coordinates" in leaf:
                use += chunk("Ftc", np.asarray(leaf["texture_coordinates"]).astype("<f4").tobytes())
            records += listed("Toj", use, self._numbers("Trc", "7r", 1, 0, 0, 0, 0, 0, 0))
        heights = np.asarray(leaf.get("heights", np.zeros((0, 0))), np.float64)
        rows, columns = heights.shape
        records += self._numbers(
            "Hfd", f"2i{heights.size}r" if heights.size else "2i", columns, rows, *heights.flat
        )
        return records + b"EOO"

    def _mesh(self, vertices: np.ndarray, triangles: np.ndarray) -> bytes:
        """Records of a leaf that refer to its mesh in the pools; in old files the mesh itself."""
        # Of vertices that are there and finite, as tests write others too.
        safe = np.clip(triangles, 0, len(vertices) - 1)
        normals = normals_of(np.nan_to_num(np.asarray(vertices, np.float64)), safe)
        packed = self.ser < 24
        data = (
            np.asarray(vertices).astype("<f4").tobytes(),
            packed_indices(triangles.ravel().tolist()) if packed else triangles.astype("<i4").tobytes(),
            packed_normals(normals) if packed else normals.astype("<f4").tobytes(),
        )
        if self.ser < 18:
            return b"".join(chunk(tag, part) for tag, part in zip(("Ver", "In2", "No2"), data, strict=True))
        index = len(self._pools["Ver"])
        for pool, part in zip(self._pools.values(), data, strict=True):
            pool.append(part)
        return b"".join(self._numbers(tag, "i", index) for tag in ("Vev", "Inv", "Nov"))


_LEAF_KEYS = (
    "color", "color_name", "opacity", "texture", "texture_scale", "texture_coordinates", "heights", "pose", "wireframe",
    "convex", "culled",
)  # fmt: skip


def _color(
    rgb: Sequence[float], ser: int, name: str = "", opacity: float = 1.0, *, tag: str = "Cl0",
    light: Sequence[float] = (0.0, 0.0, 0.0),
) -> bytes:  # fmt: skip
    """Return a list of colours, in old files in their older gamma."""
    rest = (0.2, 0.2, 0.2, 0.0, 0.0, 0.0)
    if ser < 18:
        values = numbers("Cls", "12f", (*(0.85 * part - 0.125 for part in rgb), *(0.25,) * 3, *rest), ser)
    else:
        values = numbers("Cl3", "15f", (*rgb, *light, *rest, 0.5, 0.0, 0.0), ser)
    records = values + numbers("Var", "B", (4 if opacity >= 1 else 0,), ser) + chunk("Cnm", text(name))
    return listed(tag, records, numbers("Trf", "f", (opacity,), ser))


def _parameters(tag: str, parameters: Sequence[tuple[str, str, str]]) -> bytes:
    """Return a list of user parameters, each of name, unit and value; nothing without any."""
    listing = b"".join(b"".join(map(text, each)) + struct.pack("<i", 0) for each in parameters)
    return listed(tag, chunk("Par", struct.pack("<i", len(parameters)) + listing)) if parameters else b""
