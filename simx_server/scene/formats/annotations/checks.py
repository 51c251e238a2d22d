"""The values of single keys: each function returns the value of a text, or raises ValueError with what is valid."""

from __future__ import annotations

import math
from collections.abc import Callable

from simx_server.scene.formats.texts.filter_chains import read_chain


def switch(text: str) -> bool:
    """Return whether a word means on."""
    words = {"on": True, "yes": True, "true": True, "off": False, "no": False, "false": False}
    if text.lower() not in words:
        raise ValueError("on/yes or off/no")
    return words[text.lower()]


def number(text: str) -> float:
    """Return a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError("a finite number")
    return value


def positive(text: str) -> float:
    """Return a number above 0."""
    value = number(text)
    if value <= 0:
        raise ValueError("a number above 0")
    return value


def not_negative(text: str) -> float:
    """Return a number not below 0."""
    value = number(text)
    if value < 0:
        raise ValueError("a number not below 0")
    return value


def angle(text: str) -> float:
    """Return an angle in degrees, above 0 and up to 360."""
    value = number(text)
    if not 0 < value <= 360:
        raise ValueError("degrees above 0, up to 360")
    return value


def share(text: str) -> float:
    """Return a part of a whole: from 0 up to, but not, 1."""
    value = number(text)
    if not 0 <= value < 1:
        raise ValueError("a number from 0 up to, but not, 1")
    return value


def count(text: str) -> float:
    """Return a whole number from 1 to 10,000."""
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 10_000:
        raise ValueError("a whole number from 1 to 10000")
    return int(text)


def place(text: str) -> float:
    """Return a place in an order: a whole number from 0 on, of at most nine digits."""
    if not text.isascii() or not text.isdigit() or len(text) > 9:
        raise ValueError("a whole number not below 0")
    return int(text)


def bits(text: str) -> float:
    """Return 16 bits, given in decimal, or in hexadecimal after 0x."""
    try:
        value = int(text, 0)
    except ValueError:
        value = -1
    if not 0 <= value <= 0xFFFF:
        raise ValueError("16 bits, such as 0x00ff")
    return value


def one_of(*words: str) -> Callable[[str], str]:
    """Return the check of a text that must be one of some words."""

    def check(text: str) -> str:
        if text not in words:
            raise ValueError("one of " + ", ".join(words))
        return text

    return check


def some_of(*words: str) -> Callable[[str], str]:
    """Return the check of a text that must be some words of a list with commas between them."""

    def check(text: str) -> str:
        if not text or not set(text.split(",")) <= set(words):
            raise ValueError("some of " + ", ".join(words) + " with commas between them")
        return text

    return check


DETECTABLE_KINDS = ("ultrasonic", "infrared", "laser", "inductive", "capacitive")
"""Kinds of proximity sensors; a shape or dummy may be detectable to some of them."""


def detectable(text: str) -> bool | str:
    """Return whether an object is detectable, or the kinds of sensors to which it is."""
    try:
        return switch(text)
    except ValueError:
        pass
    if not text or not set(text.split(",")) <= set(DETECTABLE_KINDS):
        kinds = ", ".join(DETECTABLE_KINDS)
        raise ValueError(f"on/yes or off/no, or some of {kinds} with commas between them")
    return text


def numbers(count: int) -> Callable[[str], str]:
    """Return the check of a text of several finite numbers with commas between them."""

    def check(text: str) -> str:
        if text.count(",") != count - 1:
            raise ValueError(f"{count} finite numbers with commas between them")
        for word in text.split(","):
            number(word)
        return text

    return check


def weights(text: str) -> str:
    """Return the text of numbers from 0 with commas between them."""
    if any(number(word) < 0 for word in text.split(",")):
        raise ValueError("numbers from 0 with commas between them")
    return text


def four_weights(text: str) -> str:
    """Return the text of four numbers from 0 with commas between them."""
    if text.count(",") != 3:
        raise ValueError("4 numbers from 0 with commas between them")
    return weights(text)


def quaternion(text: str) -> str:
    """Return the text of a quaternion w,x,y,z that is not 0."""
    if not any(map(float, numbers(4)(text).split(","))):
        raise ValueError("a quaternion w,x,y,z that is not 0")
    return text


def filters(text: str) -> str:
    """Return the text of a filter chain of a vision sensor."""
    read_chain(text)
    return text


three_numbers = numbers(3)
six_numbers = numbers(6)


def one_number(text: str) -> str:
    """Return the text of a finite number."""
    number(text)
    return text


def twelve_bytes(text: str) -> str:
    """Return the text of 12 whole numbers from 0 to 255 with spaces between them."""
    words = text.split()
    if len(words) != 12 or not all(word.isascii() and word.isdigit() and int(word) < 256 for word in words):
        raise ValueError("12 whole numbers from 0 to 255 with spaces (%20) between them")
    return text


def link_type(text: str) -> str:
    """Return the text of a dummy's type of link."""
    if text not in ("physics", "ik") and not (text.isascii() and text.isdigit() and len(text) < 10):
        raise ValueError("physics, ik, or a number of V-REP")
    return text


def looks(text: str) -> str:
    """Return the text of the colours of parts of a shape: place, and 12 numbers; semicolons between the parts."""
    for part in text.split(";"):
        place_of(part)
    return text


def place_of(part: str) -> tuple[int, tuple[float, ...]]:
    """Return the place of a part of a shape, and its 12 numbers. Raises ValueError with what is valid."""
    which, _, rest = part.partition(":")
    words = rest.split(",")
    try:
        values = tuple(map(number, words))
        if len(values) != 12 or not all(0 <= value <= 1 for value in values):
            raise ValueError
        return int(place(which)), values
    except ValueError:
        raise ValueError(
            "PLACE:12 numbers from 0 to 1 with commas between them; semicolons between parts"
        ) from None


def colour(text: str) -> str:
    """Return the text of a colour red,green,blue, each from 0 to 1."""
    if text.count(",") != 2 or not all(0 <= number(word) <= 1 for word in text.split(",")):
        raise ValueError("red,green,blue, each from 0 to 1")
    return text
