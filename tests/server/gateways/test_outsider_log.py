"""Outsiders cannot fill the log of a server."""

from __future__ import annotations

import logging

import pytest

from simx_server.gateways.outsider_log import MOST, PERIOD, OutsiderLog


def test_outsiders_write_a_few_lines_in_each_minute(caplog: pytest.LogCaptureFixture) -> None:
    now = [0.0]
    log = OutsiderLog(logging.getLogger("simx_server.test"), lambda: now[0])
    for number in range(1000):
        log.say(logging.WARNING, "%d is dropped", number)
    assert len(caplog.records) == MOST + 1
    assert "left out for a while" in caplog.messages[-1]
    now[0] += PERIOD
    caplog.clear()
    log.say(logging.WARNING, "%d is dropped", 1000)
    assert caplog.messages == [f"{1000 - MOST} more lines about connections were left out", "1000 is dropped"]
