"""A class: start, memory and processor time by the number of seats. Linux only."""

from __future__ import annotations

import http.client
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from bench.measuring.measure import Effort
from bench.measuring.processes import ROOT, NotReady
from bench.measuring.report import Findings, Grid
from bench.measuring.resources import core_share, memory_mb, private_mb, processor_seconds

SEATS = (1, 8, 30)
COMMAND = (sys.executable, "-m", "simx_client", "classroom", "ur5_rg2_kinect", "--start", "-q")
TIMEOUT_S = 60.0


@dataclass(frozen=True)
class Class:
    """A running class."""

    place: tuple[str, int]
    cookie: str
    parent: int
    started_in: float

    def children(self) -> list[int]:
        """Seats and page."""
        text = Path(f"/proc/{self.parent}/task/{self.parent}/children").read_text()
        return [int(word) for word in text.split()]

    def look(self, path: str) -> bytes:
        """Return what the teacher's browser gets there."""
        status, body = self._get(path)
        if status != http.client.OK:
            raise NotReady(f"{path}: {status} {body.decode()}")
        return body

    def has_image(self, seat: int) -> bool:
        """Return whether the browser gets an image of a seat; otherwise it shows the one before."""
        path = f"/seat/{seat}/image"
        status, body = self._get(path)
        if status not in (http.client.OK, http.client.SERVICE_UNAVAILABLE):
            raise NotReady(f"{path}: {status} {body.decode()}")
        return status == http.client.OK

    def _get(self, path: str) -> tuple[int, bytes]:
        with closing(http.client.HTTPConnection(*self.place, timeout=TIMEOUT_S)) as connection:
            connection.request("GET", path, headers={"Cookie": self.cookie})
            answer = connection.getresponse()
            return answer.status, answer.read()


@contextmanager
def running_class(seats: int) -> Generator[Class]:
    """A class of the tutorial's scene on free ports, running; ended when the block is left."""
    began = time.perf_counter()
    command = [*COMMAND, "--seats", str(seats), "--page-port", "0", "--seat-port", "0"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = process.stdout.readline()
            if not line:
                raise NotReady(f"a class of {seats} did not get ready; the log says why")
            took = time.perf_counter() - began
            parts = urlsplit(line.split()[1])
            cookie = f"simx_teacher_{parts.port}={parse_qs(parts.query)['token'][0]}"
            yield Class((str(parts.hostname), int(parts.port or 0)), cookie, process.pid, took)
        finally:
            process.terminate()


def measure(effort: Effort, seats: tuple[int, ...] = SEATS) -> Findings:
    """Classes of several sizes, one after the other: before anybody looks, and while a browser looks at all seats."""
    span = max(0.2, effort.seconds(4.0))
    found = Findings("A class")
    lines = [(str(count), _class(count, span, effort.count(5))) for count in seats]
    head = (
        "seats", "start, s", "memory, MB", "a seat's own", "cores", "looked at: memory, MB", "a seat's own", "cores",
    )  # fmt: skip
    found.grids.append(Grid(head, lines))
    found.notes.append(
        "All seats run at real time. Memory is that of all processes together; what they share counts once. The "
        "second half is while each seat's image is fetched once a second; its renderer stays afterwards."
    )
    return found


def _class(seats: int, span: float, starts: int) -> list[float]:
    taken: list[float] = []
    for _ in range(starts - 1):
        with running_class(seats) as started:
            taken.append(started.started_in)
    with running_class(seats) as started:
        taken.append(started.started_in)
        everything = [started.parent, *started.children()]
        time.sleep(span / 4)
        idle = [*_memory(everything, started), core_share(everything, span)]
        _start_renderers(started, seats)
        end = time.perf_counter() + span
        share = _share_while_looking(started, seats, everything, end)
        looked = [*_memory(everything, started), share]
    return [statistics.median(taken), *idle, *looked]


def _memory(everything: list[int], started: Class) -> list[float]:
    own = [private_mb(process_id) for process_id in started.children()]
    return [memory_mb(everything), statistics.median(own)]


def _start_renderers(started: Class, seats: int) -> None:
    for number in range(1, seats + 1):
        end = time.monotonic() + TIMEOUT_S
        while not started.has_image(number):
            if time.monotonic() > end:
                raise NotReady(f"seat {number} has no image after {TIMEOUT_S:g} s")
            time.sleep(0.1)


def _look_at_all(started: Class, seats: int) -> None:
    for number in range(1, seats + 1):
        started.has_image(number)
    json.loads(started.look("/class"))


def _share_while_looking(started: Class, seats: int, everything: list[int], end: float) -> float:
    before, began = processor_seconds(everything), time.perf_counter()
    while (now := time.perf_counter()) < end:
        _look_at_all(started, seats)
        time.sleep(max(0.0, 1.0 - (time.perf_counter() - now)))
    return (processor_seconds(everything) - before) / (time.perf_counter() - began)
