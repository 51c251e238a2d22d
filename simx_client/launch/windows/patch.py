"""Put HighGUI's functions into a ``cv2`` that has none, or none that works here. A working one stays
unchanged."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping
from types import ModuleType
from typing import Any

from . import display

FUNCTIONS = (
    *("imshow", "namedWindow", "destroyWindow", "destroyAllWindows", "moveWindow", "resizeWindow"),
    *("setWindowTitle", "getWindowImageRect", "getWindowProperty", "setWindowProperty"),
    *("displayOverlay", "displayStatusBar", "startWindowThread"),
    *("createTrackbar", "getTrackbarPos", "setTrackbarPos", "setTrackbarMin", "setTrackbarMax"),
    *("setMouseCallback", "waitKey", "waitKeyEx", "pollKey"),
)
"""Methods of `highgui.HighGui`; selectROI and selectROIs are made of them."""

_GUI = re.compile(r"^ *GUI: *(.*)\n((?: +\S.*\n)*)", re.MULTILINE)
_BUILT_IN = re.compile(r"^ +(QT|GTK\+?|Win32 UI|Cocoa|Wayland|Framebuffer)[^:]*: +YES", re.MULTILINE)


def patch_cv2(cv2: ModuleType) -> None:
    """Add windows to the module, unless it has windows that can be opened here."""
    if not hasattr(cv2, "getBuildInformation"):  # not OpenCV, but a file of the script with that name
        return
    # Editors recommended `from cv2 import cv2` for some years, which OpenCV's loader no longer allows. It
    # imports its compiled module under the same name before the package, so this is called for both.
    if hasattr(cv2, "__path__") and not hasattr(cv2, "cv2"):
        setattr(cv2, "cv2", cv2)  # noqa: B010 - a module's attribute
        sys.modules.setdefault("cv2.cv2", cv2)
    if not works_by_itself(cv2):
        _replace(cv2)


def works_by_itself(cv2: Any, environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether this OpenCV was built with a window system, and has a display: without one Qt ends the
    process."""
    if not is_built_with_windows(cv2):
        return False
    return display.is_there(environment) or bool(environment.get("QT_QPA_PLATFORM"))


def is_built_with_windows(cv2: Any) -> bool:
    """Return whether OpenCV was built with windows; before 4.5.3 only the build information says so."""
    if hasattr(cv2, "currentUIFramework"):
        try:
            return cv2.currentUIFramework() not in ("", "NONE")
        except cv2.error:
            return False
    gui = _GUI.search(cv2.getBuildInformation())
    return gui is not None and (gui[1].strip() not in ("", "NONE") or bool(_BUILT_IN.search(gui[2])))


def _replace(cv2: Any) -> None:
    from .finding import Finder
    from .highgui import HighGui
    from .regions import Regions

    if (
        getattr(getattr(cv2, "imshow", None), "__module__", "") == HighGui.__module__
    ):  # the loader's second pass
        return
    finder = Finder(cv2)
    gui = HighGui(cv2, finder.find)
    finder.ends_with(gui)
    regions = Regions(cv2, gui)
    for owner, names in ((gui, FUNCTIONS), (regions, ("selectROI", "selectROIs"))):
        for name in names:
            setattr(cv2, name, getattr(owner, name))
