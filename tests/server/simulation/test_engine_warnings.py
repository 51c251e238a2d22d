"""Python's warnings that MuJoCo's compiler gives, as several threads compile at the same time."""

from __future__ import annotations

import threading
import warnings

import pytest

from simx_server.scene import physics_warnings


def warn(text: str) -> None:
    """As MuJoCo's compiler does, called by this package."""
    registry: dict[str | tuple[str, type[Warning], int], int] = {}
    warnings.warn_explicit(
        text, DeprecationWarning, "loader.py", 1, "simx_server.scene.formats.loader", registry
    )


def test_each_thread_collects_its_own_warnings_and_all_is_as_before_in_the_end() -> None:
    filters, show = list(warnings.filters), warnings.showwarning
    first, second = threading.Event(), threading.Event()
    found: list[str] = []

    def other() -> None:
        with physics_warnings.collected() as told:
            first.set()
            warn("of the other thread")
            assert second.wait(20)  # ends after the one that began before it
        found.extend(map(str, told))

    thread = threading.Thread(target=other)
    with physics_warnings.collected() as mine:
        thread.start()
        assert first.wait(20)
        warn("of this thread")
    second.set()
    thread.join(20)
    assert ([str(each) for each in mine], found) == (["of this thread"], ["of the other thread"])
    assert (list(warnings.filters), warnings.showwarning) == (filters, show)


def test_warnings_of_others_are_filtered_and_shown_as_ever() -> None:
    with physics_warnings.collected() as told, pytest.raises(UserWarning, match="elsewhere"):
        warnings.warn_explicit("elsewhere", UserWarning, "x.py", 1, "x")
    assert told == []


def test_what_is_ignored_elsewhere_stays_ignored_meanwhile(capsys: pytest.CaptureFixture[str]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        with physics_warnings.collected() as told:
            warnings.warn_explicit(
                "old", DeprecationWarning, "zenoh.py", 1, "simx_server.gateways.zenoh.gateway", {}
            )
    assert (told, capsys.readouterr().err) == ([], "")
