"""Measures coverage while fast tests run, with their fixtures. With slow tests it would cost minutes."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from coverage import Coverage


def register(config: pytest.Config) -> None:
    """Register the plugin if pytest runs with ``--cov``, of the package pytest-cov."""
    if config.pluginmanager.hasplugin("_cov"):
        config.pluginmanager.register(CoverageOfFastTests(), "coverage_of_fast_tests")


class CoverageOfFastTests:
    """Stops and restarts the measurement that pytest-cov has started."""

    def __init__(self) -> None:
        self._measured: Coverage | None = None
        self._is_on = True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> None:
        from coverage import Coverage

        if self._is_on:
            self._measured = Coverage.current()
        is_fast = item.get_closest_marker("slow") is None
        if self._measured is None or is_fast == self._is_on:
            return
        self._is_on = is_fast
        if is_fast:
            self._measured.start()
        else:
            self._measured.stop()

    def pytest_terminal_summary(
        self, terminalreporter: pytest.TerminalReporter, config: pytest.Config
    ) -> None:
        """Print one line: the share of lines that the fast tests run in the processes of pytest."""
        from coverage import Coverage
        from coverage.exceptions import CoverageException

        measured = Coverage()
        measured.load()
        try:
            total = f"{measured.report(file=io.StringIO()):.0f} %"
        except CoverageException as error:
            total = f"not known ({error})"
        terminalreporter.write_line(f"coverage of simx_client and simx_server by the fast tests: {total}")
