"""``cv2.selectROI`` and ``selectROIs``: rectangles drawn with the mouse, made of the functions of ``highgui``."""

from __future__ import annotations

from typing import Any

from .highgui import HighGui

LEFT_DOWN, LEFT_UP, MOVE = 1, 4, 0
_DONE, _CANCEL, _ESCAPE = (13, 32), ord("c"), 27
_COLOUR = (255, 0, 0)
_NOTICE = (
    "Select a ROI and then press SPACE or ENTER button!\nCancel the selection process by pressing c button!"
)
_NOTICE_SEVERAL = "Finish the selection process by pressing ESC button!"

Rect = tuple[int, int, int, int]
NOTHING: Rect = (0, 0, 0, 0)


class Regions:
    """The two functions."""

    def __init__(self, cv2: Any, gui: HighGui) -> None:
        self._cv2, self._gui = cv2, gui

    def selectROI(self, *arguments: Any, **keywords: Any) -> Rect:
        """Return x, y, width, height of a rectangle that the user draws; zeros when cancelled, or if no key
        can come.

        Args:
            arguments: ``[windowName,] img[, showCrosshair[, fromCenter[, printNotice]]]``.
        """
        name, image, cross, from_centre, notice = _arguments(arguments, keywords)
        if notice:
            print(_NOTICE)
        rect, _ = self._select(name, image, cross, from_centre)
        self._gui.destroyWindow(name)
        return rect

    def selectROIs(self, *arguments: Any, **keywords: Any) -> Any:
        """Select several rectangles until Escape; return (count, 4) int32, an empty tuple for none."""
        import numpy as np

        name, image, cross, from_centre, notice = _arguments(arguments, keywords)
        if notice:
            print(f"{_NOTICE}\n{_NOTICE_SEVERAL}")
        found: list[Rect] = []
        while True:
            rect, key = self._select(name, image, cross, from_centre)
            if rect != NOTHING:
                found.append(rect)
            if key in (_ESCAPE, -1):
                break
        self._gui.destroyWindow(name)
        return np.array(found, np.int32) if found else ()

    def _select(self, name: str, image: Any, cross: bool, from_centre: bool) -> tuple[Rect, int]:
        """Return a rectangle, and the key that ended the selection; -1 if none can come."""
        gui, cv2 = self._gui, self._cv2
        height, width = image.shape[:2]
        begin: list[int] = []
        rect = NOTHING
        held = False

        def on_mouse(event: int, x: int, y: int, flags: int, param: object) -> None:
            nonlocal rect, held
            if event == LEFT_DOWN:
                begin[:], held, rect = [x, y], True, NOTHING
            elif event in (MOVE, LEFT_UP) and held:
                rect = _between(begin[0], begin[1], x, y, width, height, from_centre=from_centre)
                held = event == MOVE
            else:
                return
            draw()

        def draw() -> None:
            shown = image.copy()
            x, y, columns, rows = rect
            if rect != NOTHING:
                cv2.rectangle(shown, (x, y), (x + columns, y + rows), _COLOUR, 2)
                if cross:
                    middle = x + columns // 2, y + rows // 2
                    cv2.line(shown, (x, middle[1]), (x + columns, middle[1]), _COLOUR, 2)
                    cv2.line(shown, (middle[0], y), (middle[0], y + rows), _COLOUR, 2)
            gui.imshow(name, shown)

        draw()
        gui.setMouseCallback(name, on_mouse)
        while True:
            key = gui.waitKey(0)
            if key == -1 or key == _CANCEL:
                return NOTHING, key
            if key in _DONE or key == _ESCAPE:
                return (NOTHING if key == _ESCAPE else rect), key


def _between(x0: int, y0: int, x1: int, y1: int, width: int, height: int, *, from_centre: bool) -> Rect:
    if from_centre:
        x0, y0 = 2 * x0 - x1, 2 * y0 - y1
    left, right = sorted((min(max(x0, 0), width), min(max(x1, 0), width)))
    top, bottom = sorted((min(max(y0, 0), height), min(max(y1, 0), height)))
    return left, top, right - left, bottom - top


def _arguments(arguments: tuple[Any, ...], keywords: dict[str, Any]) -> tuple[str, Any, bool, bool, bool]:
    """Return window, image, cross-hair, from the centre, notice: OpenCV takes the window's name first, or not
    at all."""
    rest = list(arguments)
    if rest and isinstance(rest[0], str):
        name = rest.pop(0)
    else:
        name = keywords.get("windowName", "ROI selector")
    names = ("img", "showCrosshair", "fromCenter", "printNotice")
    given = {"showCrosshair": True, "fromCenter": False, "printNotice": True, **keywords}
    given.update(zip(names, rest, strict=False))
    return (
        name,
        given["img"],
        bool(given["showCrosshair"]),
        bool(given["fromCenter"]),
        bool(given["printNotice"]),
    )
