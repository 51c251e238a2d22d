"""Restore names of Pillow and SciPy that old scripts use and newer versions removed.

Sources: Pillow's deprecations 10.0 (``ANTIALIAS``); SciPy's release notes 1.2 and 1.3 (the images of ``scipy.misc``,
which Pillow made), 1.1 (windows), 1.14 (``simps``, ``trapz``, ``cumtrapz``), 1.6 (``from_dcm``). An array of
an image was writable before NumPy 1.16.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any, cast

from simx_client.launch.after_import import Patch

from .immutable import set_attributes
from .keywords import give_missing


def _writable(interface: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return an image's array interface whose pixels may be written: NumPy uses bytes, which it must not change."""

    def writable(image: Any) -> Any:
        described: dict[str, Any] = interface(image)
        if isinstance(described.get("data"), bytes):
            described["data"] = bytearray(described["data"])
        return described

    return writable


def _pillow(module: Any) -> None:
    give_missing(module, ANTIALIAS=module.LANCZOS, fromstring=module.frombytes)
    give_missing(module.Image, tostring=module.Image.tobytes)
    interface: Any = getattr(module.Image, "__array_interface__", None)
    if isinstance(interface, property) and interface.fget is not None:
        module.Image.__array_interface__ = property(_writable(interface.fget))


def _renamed(names: dict[str, str]) -> Patch:
    def give(module: ModuleType) -> None:
        give_missing(
            module, **{old: getattr(module, new) for old, new in names.items() if hasattr(module, new)}
        )

    return give


def _windows(signal: Any) -> None:
    names = ("gaussian", "hann", "hamming", "blackman", "triang", "kaiser", "boxcar", "general_gaussian")
    give_missing(
        signal, hanning=signal.windows.hann, **{name: getattr(signal.windows, name) for name in names}
    )


def _rotations(module: Any) -> None:
    rotation = module.Rotation  # a type written in C in SciPy 1.6 to 1.16
    old = {"from_dcm": rotation.from_matrix, "as_dcm": rotation.as_matrix}
    set_attributes(rotation, {name: each for name, each in old.items() if not hasattr(rotation, name)})


# --- scipy.misc --------------------------------------------------------------------------------------


def _to_bytes(pixels: Any) -> Any:
    """Convert grey values or colours of any range to bytes: other types than bytes are scaled to 0..255."""
    import numpy as np

    values = cast(Any, np.asarray(pixels))
    if values.dtype == np.uint8:
        return values
    low, high = values.min(), values.max()
    return ((values - low) * (255.0 / ((high - low) or 1))).round().astype(np.uint8)


def _toimage(arr: Any, *_: Any, mode: str | None = None, **__: Any) -> Any:
    from PIL import Image

    image = Image.fromarray(_to_bytes(arr))
    return image.convert(mode) if mode else image


def _imread(name: Any, flatten: bool = False, mode: str | None = None) -> Any:
    import numpy as np
    from PIL import Image

    with Image.open(name) as image:
        picture = image.convert(mode or ("RGB" if image.mode in ("P", "CMYK") else image.mode))
        return np.array(picture.convert("F") if flatten else picture)


def _fromimage(image: Any) -> Any:
    import numpy as np

    return np.array(image)


def _imsave(name: Any, arr: Any, format: str | None = None) -> None:
    _toimage(arr).save(name, format)


def _imresize(arr: Any, size: Any, interp: str = "bilinear", mode: str | None = None) -> Any:
    """Resize an image; ``size`` is a percentage, a fraction, or (height, width)."""
    import numpy as np
    from PIL import Image

    image = _toimage(arr, mode=mode)
    if np.ndim(size) == 0:
        factor = size if isinstance(size, float) else size / 100
        shape = (int(image.width * factor), int(image.height * factor))
    else:
        shape = (int(size[1]), int(size[0]))
    method: Any = getattr(Image.Resampling, {"cubic": "BICUBIC"}.get(interp, interp.upper()))
    return np.array(image.resize(shape, method))


def _imrotate(arr: Any, angle: float, interp: str = "bilinear") -> Any:
    import numpy as np
    from PIL import Image

    return np.array(_toimage(arr).rotate(angle, getattr(Image.Resampling, interp.upper())))


def _images(module: ModuleType) -> None:
    give_missing(
        module,
        bytescale=_to_bytes, imread=_imread, imresize=_imresize, imrotate=_imrotate, imsave=_imsave, toimage=_toimage,
        fromimage=_fromimage,
    )  # fmt: skip


LIBRARIES: dict[str, Patch] = {
    "PIL.Image": _pillow,
    "scipy.misc": _images,
    "scipy.signal": _windows,
    "scipy.integrate": _renamed(
        {"simps": "simpson", "trapz": "trapezoid", "cumtrapz": "cumulative_trapezoid"}
    ),
    "scipy.spatial.transform": _rotations,
}
"""Patch by the name of the module."""
