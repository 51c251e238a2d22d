"""How much of what public programs call is there.

`census.csv` counts the calls in 60 public repositories on GitHub whose programs use the ZeroMQ remote API: the
functions, how many repositories call each, and in how many places.
"""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

from simx_server.sim_api.listing.coverage import Support, script_functions

CENSUS = Path(__file__).with_name("census.csv")

WHOLE_FOR_CLIENTS = {"sim.stopSimulation"}
"""Functions that lack something in scripts only: a client's call returns after the stop."""


def test_nearly_all_calls_of_public_programs_are_provided() -> None:
    known = {each.name: each.support for each in script_functions()}
    known |= dict.fromkeys(WHOLE_FOR_CLIENTS, Support.FULL)
    calls: Counter[Support] = Counter()
    absent: dict[str, int] = {}
    with CENSUS.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            support = known.get(row["function"], Support.NONE)
            calls[support] += int(row["calls"])
            if support is Support.NONE:
                absent[row["function"]] = int(row["calls"])
    total = calls.total()
    share = {level: calls[level] / total for level in Support}
    assert share[Support.FULL] >= 0.96, share
    assert share[Support.FULL] + share[Support.PARTLY] >= 0.99, share
    assert sum(absent.values()) <= 0.003 * total, absent
