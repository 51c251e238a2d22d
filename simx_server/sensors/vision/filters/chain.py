"""Filter chains: components that a vision sensor of V-REP 3 applies to each of its images.

The image and the depth go through a work image with two buffers. Components may set the image that clients receive,
report packets of numbers, and detect something. Work image and buffers are black at the start of a run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import CameraImage
from simx_server.scene.formats.texts.filter_chains import Component

from . import detections
from . import image_filters as filters
from .image_filters import Image
from .work import View, Work


@dataclass(frozen=True, eq=False)
class Processed:
    """An image after its chain."""

    image: CameraImage
    """The image as it was made; the statistics are of this."""
    rgb: NDArray[np.uint8]
    """(height, width, 3): the image that clients receive; black if no component set one."""
    depth: NDArray[np.float32]
    """(height, width)."""
    detects: bool = False
    packets: tuple[list[float], ...] = ()


@dataclass
class Run:
    """One image on its way through a chain."""

    image: CameraImage
    view: View
    work: Work
    output: Image | None = None
    depth: NDArray[np.float64] | None = None
    detects: bool = False
    packets: list[list[float]] = field(default_factory=list[list[float]])


class Chain:
    """The components of a sensor, in their order. Immutable."""

    def __init__(self, components: Iterable[Component]) -> None:
        self.components = tuple(components)
        self.remembers = _remembers(self.components)
        """Whether results depend on earlier images: then each simulation step must process one, and no more."""
        self.sets_depth = any(component.name == "output_depth" for component in self.components)
        self.may_detect = any(
            component.name == "binary" and component.values[-1] for component in self.components
        )

    def process(self, image: CameraImage, view: View, work: Work) -> Processed:
        """Return an image after all components.

        Args:
            image: both channels.
            view: the view that it shows.
            work: the images of the run before; they change.
        """
        assert image.rgb is not None
        assert image.depth is not None
        run = Run(image, view, work)
        for component in self.components:
            _STEPS[component.name].apply(run, *component.values)
        output = np.zeros_like(work.image) if run.output is None else run.output
        depth = image.depth if run.depth is None else np.clip(run.depth, 0.0, 1.0).astype(np.float32)
        return Processed(image, _bytes(output), depth, run.detects, tuple(run.packets))

    @staticmethod
    def new_work(width: int, height: int) -> Work:
        """Return black images of a size."""
        return Work.beginning_with(np.zeros((height, width, 3)))


@dataclass(frozen=True)
class _Step:
    apply: Callable[..., None]
    reads: str = "w"
    """Images that it depends on: w work image, 1 and 2 the buffers."""
    writes: str = "w"


def _remembers(components: Iterable[Component]) -> bool:
    known: set[str] = set()
    for component in components:
        step = _STEPS[component.name]
        if not set(step.reads) <= known:
            return True
        known |= set(step.writes)
    return False


def _bytes(image: Image) -> NDArray[np.uint8]:
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)


def _changed(change: Callable[..., Image]) -> _Step:
    """Return a step that replaces the work image by a function of it."""

    def apply(run: Run, *values: Any) -> None:
        run.work.image = change(run.work.image, *values)

    return _Step(apply)


def _image(run: Run) -> None:
    assert run.image.rgb is not None
    run.work.take(run.image.rgb / 255.0)


def _depth(run: Run) -> None:
    assert run.image.depth is not None
    run.work.take(filters.as_grey(run.image.depth.astype(np.float64)))


def _output(run: Run) -> None:
    run.output = run.work.image


def _output_depth(run: Run) -> None:
    run.depth = filters.intensity(run.work.image)


def _to_buffer1(run: Run) -> None:
    run.work.buffer1 = run.work.image


def _to_buffer2(run: Run) -> None:
    run.work.buffer2 = run.work.image


def _from_buffer1(run: Run) -> None:
    run.work.image = run.work.buffer1


def _from_buffer2(run: Run) -> None:
    run.work.image = run.work.buffer2


def _swap_buffers(run: Run) -> None:
    run.work.buffer1, run.work.buffer2 = run.work.buffer2, run.work.buffer1


def _swap_with_buffer1(run: Run) -> None:
    run.work.image, run.work.buffer1 = run.work.buffer1, run.work.image


def _matrix(image: Image, passes: int, factor: float, *matrix: float) -> Image:
    return filters.convolved_often(image, np.array(matrix) * factor, passes)


def _uniform(image: Image, *colour: float) -> Image:
    return np.tile(np.array(colour), (*image.shape[:2], 1))


def _edges(image: Image, threshold: float) -> Image:
    return filters.edges(image, threshold)


def _select_colour(run: Run, *values: Any) -> None:
    rgb, keep, to_buffer1 = values[6:]
    chosen = filters.is_coloured(run.work.image, list(values[:3]), list(values[3:6]), rgb)
    run.work.keep(chosen == keep, to_buffer1)


def _scale_colours(image: Image, *values: Any) -> Image:
    return filters.scaled_and_offset(image, list(values[:3]), list(values[3:6]), list(values[6:9]), values[9])


def _rectangle(run: Run, width: float, height: float, to_buffer1: bool) -> None:
    run.work.keep(filters.within_rectangle(run.work.image.shape, width, height), to_buffer1)


def _circle(run: Run, radius: float, to_buffer1: bool) -> None:
    run.work.keep(filters.within_circle(run.work.image.shape, radius), to_buffer1)


def _binary(run: Run, threshold: float, *values: Any) -> None:
    *limits, triggers = values
    is_as_wanted, packet = detections.find_patch(run.work, threshold, detections.Wanted(*limits))
    run.detects |= triggers and is_as_wanted
    run.packets.append(packet)


def _blobs(run: Run, threshold: float, least_size: float, paint_apart: bool) -> None:
    run.packets.append(detections.find_blobs(run.work, threshold, least_size, paint_apart))


def _changes(run: Run, threshold: float) -> None:
    packet = detections.find_changes(run.work, threshold)
    if packet:
        run.packets.append(packet)


def _coordinates(run: Run, across: int, up: int, even_angles: bool) -> None:
    points, _ = detections.find_coordinates(run.work, run.view, (across, up), even_angles)
    run.packets.append(detections.packet_of((across, up), points))


def _velodyne(run: Run, across: int, up: int, angle: float) -> None:
    points = detections.scan(run.work, run.view, (across, up), angle)
    run.packets.append(detections.packet_of((across, up), points))


def _work(method: Callable[[Work], None]) -> Callable[[Run], None]:
    def apply(run: Run) -> None:
        method(run.work)

    return apply


_STEPS: dict[str, _Step] = {
    "image": _Step(_image, reads=""),
    "depth": _Step(_depth, reads=""),
    "uniform": _Step(_changed(_uniform).apply, reads=""),
    "output": _Step(_output, writes=""),
    "output_depth": _Step(_output_depth, writes=""),
    "to_buffer1": _Step(_to_buffer1, writes="1"),
    "to_buffer2": _Step(_to_buffer2, writes="2"),
    "from_buffer1": _Step(_from_buffer1, reads="1"),
    "from_buffer2": _Step(_from_buffer2, reads="2"),
    "swap_buffers": _Step(_swap_buffers, reads="12", writes="12"),
    "swap_with_buffer1": _Step(_swap_with_buffer1, reads="w1", writes="w1"),
    "add_buffer1": _Step(_work(Work.add_buffer1), reads="w1"),
    "subtract_buffer1": _Step(_work(Work.subtract_buffer1), reads="w1"),
    "multiply_with_buffer1": _Step(_work(Work.multiply_with_buffer1), reads="w1"),
    "add_to_buffer1": _Step(_work(Work.add_to_buffer1), reads="w1", writes="1"),
    "subtract_from_buffer1": _Step(_work(Work.subtract_from_buffer1), reads="w1", writes="1"),
    "flip_horizontally": _changed(filters.flipped_horizontally),
    "flip_vertically": _changed(filters.flipped_vertically),
    "rotate": _changed(filters.rotated),
    "shift": _changed(filters.shifted),
    "resize": _changed(filters.resized),
    "matrix3": _changed(_matrix),
    "matrix5": _changed(_matrix),
    "sharpen": _changed(filters.sharpened),
    "edges": _changed(_edges),
    "rectangle": _Step(_rectangle, writes=""),
    "circle": _Step(_circle, writes=""),
    "normalise": _changed(filters.normalised),
    "intensity_scale": _changed(filters.intensity_scaled),
    "select_colour": _Step(_select_colour, writes=""),
    "scale_colours": _changed(_scale_colours),
    "merge_colours": _changed(filters.with_fewer_colours),
    "binary": _Step(_binary),
    "blobs": _Step(_blobs),
    "coordinates": _Step(_coordinates, writes=""),
    "changes": _Step(_changes, reads="w2", writes="w2"),
    "velodyne": _Step(_velodyne, writes=""),
}
"""The components by their names in `filter_chains.COMPONENTS`."""
