"""Restore names of matplotlib that old scripts use and newer versions removed, per module.

Sources: matplotlib's API changes 2.2 (``axisbg``, ``normed``, ``set_color_cycle``), 3.0 (``hold``), 3.3
(``use(warn=)``, ``annotate(s=)``), 3.6 (``set_window_title`` of a canvas), 3.7 (``gca(projection=)``, lists of
artists, ``set_data`` of numbers, ``Axes3D(fig)``), 3.8 (``w_xaxis``, seaborn styles), 3.9 (``cm.get_cmap``).
"""

from __future__ import annotations

import functools
import inspect
import numbers
from collections.abc import Callable
from types import ModuleType
from typing import Any

from simx_client.launch.after_import import Patch

from .keywords import DROPPED, calling, give_missing, take_old_keywords

_ARTISTS = ("artists", "collections", "images", "lines", "patches", "tables", "texts")


def _main(matplotlib: ModuleType) -> None:
    take_old_keywords(matplotlib, "use", warn=DROPPED)


def _figure(module: ModuleType) -> None:
    base: Any = getattr(module, "FigureBase", module.Figure)
    take_old_keywords(module.Figure, "savefig", frameon=DROPPED, papertype=DROPPED)
    plain = base.gca
    if len(inspect.signature(plain).parameters) > 1:
        return

    def gca(self: Any, **kwargs: Any) -> Any:
        """Return the current axes with this projection, or new ones."""
        wanted = kwargs.get("projection")
        current = self.axes and plain(self)
        if not kwargs or (current and wanted in (None, current.name)):
            return plain(self)
        return self.add_subplot(1, 1, 1, **kwargs)

    base.gca = functools.wraps(plain)(gca)


def _pyplot(pyplot: Any) -> None:
    give_missing(pyplot, hold=_nothing, ishold=_always)
    if inspect.signature(pyplot.gca).parameters:
        return

    def gca(**kwargs: Any) -> Any:
        """Call the method of the current figure."""
        return pyplot.gcf().gca(**kwargs)

    pyplot.gca = gca


def _canvas(module: ModuleType) -> None:
    def set_window_title(self: Any, title: str) -> None:
        if self.manager is not None:
            self.manager.set_window_title(title)

    def get_window_title(self: Any) -> str | None:
        return None if self.manager is None else self.manager.get_window_title()

    give_missing(
        module.FigureCanvasBase, set_window_title=set_window_title, get_window_title=get_window_title
    )


def _axes(module: ModuleType) -> None:
    base: Any = module._AxesBase
    take_old_keywords(base, "__init__", axisbg="facecolor", axis_bgcolor="facecolor")
    take_old_keywords(base, "grid", b="visible")
    give_missing(
        base,
        set_axis_bgcolor=calling("set_facecolor"),
        get_axis_bgcolor=calling("get_facecolor"),
        set_color_cycle=_set_color_cycle,
        hold=_nothing,
        ishold=_always,
    )
    artists: Any = getattr(base, "ArtistList", None)
    if artists is None:
        return
    give_missing(artists, remove=_remove, pop=_pop, append=_append, clear=_clear, __delitem__=_delete)
    for name in _ARTISTS:
        plain = getattr(base, name, None)
        if isinstance(plain, property) and plain.fset is None:
            setattr(base, name, plain.setter(functools.partial(_set_artists, name)))


def _plots(module: ModuleType) -> None:
    take_old_keywords(module.Axes, "hist", normed="density")
    take_old_keywords(module.Axes, "annotate", s="text")


def _axes_3d(module: ModuleType) -> None:
    kind: Any = module.Axes3D
    give_missing(kind, **{f"w_{name}": _attribute(name) for name in ("xaxis", "yaxis", "zaxis")})
    plain = kind.__init__
    if "auto_add_to_figure" in inspect.signature(plain).parameters or hasattr(plain, "adds_to_figure"):
        return

    def init(self: Any, fig: Any, *args: Any, **kwargs: Any) -> None:
        """Add the axes to the figure, as ``Axes3D(fig)`` did; a second time by add_subplot is harmless."""
        plain(self, fig, *args, **kwargs)
        fig.add_axes(self)

    made = functools.wraps(plain)(init)
    setattr(made, "adds_to_figure", True)  # noqa: B010 - its type does not know the attribute
    kind.__init__ = made


def _lines(module: ModuleType) -> None:
    kind: Any = module.Line2D
    for name in ("set_xdata", "set_ydata"):
        plain = getattr(kind, name)
        if not hasattr(plain, "takes_numbers"):
            made = _taking_numbers(plain)
            setattr(made, "takes_numbers", True)  # noqa: B010 - its type does not know the attribute
            setattr(kind, name, made)


def _maps(module: ModuleType) -> None:
    def get_cmap(name: Any = None, lut: int | None = None) -> Any:
        import matplotlib

        maps: Any = matplotlib.colormaps  # pyright: ignore[reportAttributeAccessIssue]
        chosen: Any = (
            maps[name or matplotlib.rcParams["image.cmap"]] if name is None or isinstance(name, str) else name
        )
        return chosen if lut is None else chosen.resampled(lut)

    give_missing(module, get_cmap=get_cmap)
    if hasattr(module, "nipy_spectral"):
        give_missing(module, spectral=module.nipy_spectral)


def _styles(module: ModuleType) -> None:
    library: Any = module.library
    for name in list(library):
        if name.startswith("seaborn-v0_8"):
            library.setdefault(name.replace("-v0_8", ""), library[name])


def _tk(module: ModuleType) -> None:
    give_missing(module, NavigationToolbar2TkAgg=module.NavigationToolbar2Tk)
    give_missing(module.FigureCanvasTkAgg, show=calling("draw"))


def _nothing(*_: Any, **__: Any) -> None:
    """Do nothing: replaces functions without effect since matplotlib 2."""


def _always(*_: Any) -> bool:
    return True


def _set_color_cycle(self: Any, colors: Any) -> None:
    self.set_prop_cycle(color=colors)


def _attribute(name: str) -> property:
    def get(self: Any) -> Any:
        return getattr(self, name)

    return property(get)


def _taking_numbers(plain: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(plain)
    def set_data(self: Any, values: Any) -> None:
        plain(self, [values] if isinstance(values, numbers.Number) else values)

    return set_data


def _remove(self: Any, artist: Any) -> None:
    artist.remove()


def _pop(self: Any, place: int = -1) -> Any:
    artist = self[place]
    artist.remove()
    return artist


def _append(self: Any, artist: Any) -> None:
    self._axes.add_artist(artist)


def _clear(self: Any) -> None:
    for artist in list(self):
        artist.remove()


def _delete(self: Any, place: Any) -> None:
    chosen = self[place]
    for artist in list(chosen) if isinstance(place, slice) else [chosen]:
        artist.remove()


def _set_artists(name: str, axes: Any, artists: Any) -> None:
    """Set artists as ``ax.lines = []`` did: remove those that stay and add them again, in their new order."""
    artists = list(artists)
    for artist in list(getattr(axes, name)):
        artist.remove()
    for artist in artists:
        axes.add_artist(artist)


MATPLOTLIB: dict[str, Patch] = {
    "matplotlib": _main,
    "matplotlib.figure": _figure,
    "matplotlib.pyplot": _pyplot,
    "matplotlib.backend_bases": _canvas,
    "matplotlib.axes._base": _axes,
    "matplotlib.axes._axes": _plots,
    "mpl_toolkits.mplot3d.axes3d": _axes_3d,
    "matplotlib.lines": _lines,
    "matplotlib.cm": _maps,
    "matplotlib.style": _styles,
    "matplotlib.backends.backend_tkagg": _tk,
}
"""Patch by the name of the module."""
