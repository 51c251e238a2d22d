"""Parts of V-REP files beside objects: settings, textures, collections, interfaces. Part of `vrep_writer.py`."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from vrep_packing import array, chunk, listed, numbers, text

CUSTOM_DATA_HEADER = 356248756

Triple = tuple[float, float, float]


class RestOfFile:
    """The records of the top level of one file in the making."""

    def __init__(self, ser: int, program: tuple[int, int, int]) -> None:
        self.ser = ser
        self.program = program
        self.records: list[bytes] = []
        """Finished records, for tests that want others."""
        self._ids = 0

    def texture(self, pixels: np.ndarray) -> int:
        """Add a texture of (height, width, 3 or 4) bytes; returns its id."""
        height, width, channels = pixels.shape
        number = 2180000 + self._next_id()
        records = self._numbers("Ipa", "3i", number, width, height) + self._numbers(
            "Bst", "B", int(channels == 4)
        )
        self.records.append(listed("TEX", records, chunk("Img", pixels.astype(np.uint8).tobytes())))
        return number

    def collection(
        self, name: str, entries: Sequence[tuple[int, int, bool]], *, overrides: bool = False
    ) -> int:
        """Add a collection of (object, kind, additive); returns its id."""
        number = 2000000 + self._next_id()
        records = chunk("Grn", text(name)) + self._numbers("Gix", "i", number)
        records += self._numbers("Par", "B", int(overrides))
        for item, kind, additive in entries:
            member = self._numbers("Obj", "2i", item, 0) + self._numbers("Gty", "B", kind)
            records += listed("Asg", member, self._numbers("Var", "B", int(additive)))
        self.records.append(listed("GRP", records))
        return number

    def collision(self, name: str, first: int, second: int = -1) -> int:
        """Add a collision object; returns its id."""
        number = 2010000 + self._next_id()
        records = self._numbers("Inx", "3i", first, second, number) + chunk("Nme", text(name))
        self.records.append(listed("COL", records))
        return number

    def planning(
        self,
        name: str,
        *,
        path: int,
        start: int,
        goal: int,
        robot: int,
        obstacles: int = -1,
        kind: int = 0,
        low: Sequence[float] = (-1, -1, -1),
        extent: Sequence[float] = (2, 2, 2),
    ) -> int:
        """Add a path planning task; returns its id."""
        number = 2020000 + self._next_id()
        between = [value for pair in zip(low, extent, strict=True) for value in pair]
        records = self._numbers("Idx", "3i", path, robot, obstacles) + self._numbers("Gid", "i", goal)
        records += self._numbers("Pod", "i", start) + self._numbers("Ttp", "i", kind)
        records += self._numbers("Rn2", "8f", *between, -3, 6) + self._numbers("Mxt", "f", 2.5)
        records += chunk("Nme", text(name)) + self._numbers("Oid", "i", number)
        self.records.append(listed("PPL", records))
        return number

    def motion_planning(
        self,
        name: str,
        *,
        joints: Sequence[int],
        group: int,
        robot: int = -1,
        obstacles: int = -1,
        own: tuple[int, int] = (-1, -1),
        clearances: tuple[float, float] = (0, 0),
        weights: Sequence[float] = (),
    ) -> int:
        """Add a motion planning task; returns its id."""
        number = 2020000 + self._next_id()
        count = len(joints)
        records = chunk("Nme", text(name)) + self._numbers("Oid", "i", number)
        records += self._numbers("Jhn", f"i{count}i", count, *joints)
        records += self._numbers("Jsc", f"i{count}i", count, *[10] * count) + self._numbers("Ikg", "i", group)
        records += self._numbers("Ety", "4i", robot, obstacles, *own) + self._numbers(
            "Cdt", "2f", *clearances
        )
        records += self._numbers("Tmc", "4f", 1, 1, 1, 0.25)
        records += self._numbers("Jmc", f"i{count}f", count, *weights) + self._numbers("Var", "B", 1)
        self.records.append(listed("MPL", records))
        return number

    def distance(self, name: str, first: int, second: int = -1, *, threshold: float = 0.0) -> int:
        """Add a distance object; returns its id."""
        number = 2020000 + self._next_id()
        records = self._numbers("Inx", "3i", first, second, number) + chunk("Nme", text(name))
        self.records.append(listed("DST", records, self._numbers("Trh", "f", threshold)))
        return number

    def ik_group(
        self, name: str, elements: Sequence[Mapping[str, Any]], *, iterations: int = 3, damping: float = 0.1,
        damped: bool = False, enabled: bool = True, explicit: bool = False, limits_steps: bool = False,
    ) -> int:  # fmt: skip
        """Add a group of elements with tip, and perhaps base, constraints; returns its id."""
        number = 2030000 + self._next_id()
        records = self._numbers("Oid", "i", number) + chunk("Nme", text(name))
        records += self._numbers("Mit", "i", iterations) + self._numbers("Dpg", "r", damping)
        flags = enabled + 32 * limits_steps + 64 * explicit
        records += self._numbers("Cmt", "i", int(damped)) + self._numbers("Var", "B", flags)
        for each in elements:
            element = self._numbers("Ik2", "2i", each["tip"], each.get("base", -1))
            element += self._numbers("Ctr", "i", each.get("constraints", 0x1F)) + self._numbers("Var", "B", 1)
            element += self._numbers("Pr2", "2f", 0.0005, 0.01) + self._numbers("Wgt", "2f", 1, 1)
            records += listed("Ike", element)
        self.records.append(listed("IKO", records))
        return number

    def old_ui(
        self, name: str, buttons: Sequence[Mapping[str, Any]], *, owner: int = -1, size: tuple[int, int] = (6, 4),
        attributes: int = 0x17, is_double: bool = False,
    ) -> int:  # fmt: skip
        """Add an old user interface of buttons with id, at, size, attributes, label, down, slider (0 to 1000).

        Args:
            is_double: as written since CoppeliaSim 4.5.

        Returns its handle.
        """
        number = 2060000 + self._next_id()
        records = self._numbers("Bkh", "i", number) + self._numbers("Att", "i", attributes)
        records += (
            chunk("Bkn", text(name)) + self._numbers("Bks", "2i", *size) + self._numbers("Aoi", "i", owner)
        )
        for each in buttons:
            fields = (
                each.get("attributes", 0x2010),
                each["id"],
                *each.get("size", (1, 1)),
                *each.get("at", (0, 0)),
            )
            data = struct.pack("<6i", *fields) + text(each.get("label", "")) + text(each.get("down", ""))
            slider = struct.pack("<d" if is_double else "<f", each.get("slider", 0) / 500 - 1)
            colors = self._numbers("Bnc", "9f", *(0.7,) * 3, *(0.5,) * 3, *(0.0,) * 3)
            records += listed("Btn", chunk("_va" if is_double else "Bva", data + slider), colors)
        self.records.append(listed("BBK", records))
        return number

    def settings(
        self, *, time_step: float = 0.05, physics_step: float = 0.005, real_time: bool = False, engine: int = 0,
        gravity: Triple = (0.0, 0.0, -9.81), dynamics: bool = True, layers: int = 0xFF, choice: int = 5,
        bullet: int | None = None,
    ) -> None:  # fmt: skip
        """Add the settings of a scene.

        `choice`: in V-REP's list of simulation steps; 5 is `time_step`. `bullet`: 0 for version 2.78, 283.
        """
        steps = self._numbers("Sts", "f", time_step) + self._numbers("St2", "q", round(time_step * 1e6))
        if self.ser >= 23:
            steps += self._numbers("St3", "r", time_step)
        steps += self._numbers("Spi", "i", choice)
        self.records.append(listed("SIM", steps, self._numbers("Ss2", "B", int(real_time))))
        tag = "En2" if self.program < (4, 2, 0) else "En3"
        records = self._numbers(tag, "i3r1i", engine, *gravity, 1) if tag == "En3" else self._numbers(
            tag, "i3f1i", engine, *gravity, 1
        )  # fmt: skip
        records += b"" if bullet is None else self._numbers("Ver", "i", bullet)
        records += array("BuN", (physics_step, 10, 0.1, 0, 0), (100, 0, 0), self.ser)
        records += self._numbers("Stp", "r", physics_step) if self.ser >= 24 else b""
        self.records.append(listed("DYN", records, self._numbers("Var", "B", int(dynamics))))
        environment = self._numbers("Clc", "3f", 0.8, 0.85, 0.9) + self._numbers("Cld", "3f", 0.1, 0.1, 0.2)
        environment += self._numbers("Al2", "3f", 0.4, 0.4, 0.4) + chunk("Ack", text(""))
        self.records.append(listed("ENV", environment))
        self.records.append(listed("SET", self._numbers("Al2", "H", layers)))

    def thumbnail(self, pixels: np.ndarray) -> None:
        """Add a thumbnail of (128, 128, 3), rows bottom first."""
        opaque = np.full((128, 128, 1), 255, np.uint8)
        data = np.concatenate((pixels.astype(np.uint8), opaque), axis=2).tobytes()
        self.records.append(listed("MTC", chunk("Tm2", b"\1\0" + data)))

    def model_information(self, position: Triple, size: Triple) -> None:
        """Add a model's pose and bounding box."""
        self.records.append(listed("BBC", self._numbers("Mo2", "11r", *position, 1, 0, 0, 0, *size, 0.0)))

    def scene_data(self, blocks: Mapping[str, bytes]) -> None:
        """Add custom data blocks of the scene."""
        tag, records = self._custom_data(blocks)
        self.records.append(listed("CDA" if tag == "Cda" else "CDS", records))

    def _next_id(self) -> int:
        self._ids += 1
        return self._ids

    def _numbers(self, tag: str, form: str, *values: Any) -> bytes:
        return numbers(tag, form, values, self.ser)

    def _custom_data(self, blocks: Mapping[str, bytes]) -> tuple[str, bytes]:
        if self.program >= (4, 3, 0):
            return "Cda", b"".join(
                chunk("Cdt", text(tag) + struct.pack("<i", len(data)) + data) for tag, data in blocks.items()
            )
        entries = b""
        for tag, data in blocks.items():
            name = tag.encode() + b"\0"
            entries += struct.pack("<2i", 8 + len(name) + len(data), len(name)) + name + data
        return "Cod", chunk("Dat", struct.pack("<2i", CUSTOM_DATA_HEADER, len(entries)) + entries)
