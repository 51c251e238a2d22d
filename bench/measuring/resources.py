"""What processes take of the machine: memory, processor time, bytes on the wire. Linux only."""

from __future__ import annotations

import os
import re
import socket
import struct
import time
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from pathlib import Path

_TCP_INFO_BYTES = 120
"""Offset of tcpi_bytes_acked in struct tcp_info (linux/tcp.h); tcpi_bytes_received follows."""


def keep_apart() -> set[int]:
    """Have this process and the server run on one core, and the attackers on the others, which are returned.

    Programs that never wait take what there is of the cores, whatever the server does.
    """
    if not hasattr(os, "sched_setaffinity"):
        return set()
    *others, own = sorted(os.sched_getaffinity(0))
    if others:
        os.sched_setaffinity(0, {own})
    return set(others)


@contextmanager
def on_one_core(*process_ids: int) -> Generator[None]:
    """Have all threads of these processes share a core within the block, where the system can do that."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    threads = [int(task.name) for each in process_ids for task in Path(f"/proc/{each}/task").iterdir()]
    cores = os.sched_getaffinity(0)
    _keep(threads, {min(cores)})
    try:
        yield
    finally:
        _keep(threads, cores)


def _keep(threads: list[int], cores: set[int]) -> None:
    for thread in threads:
        with suppress(OSError):  # it has ended
            os.sched_setaffinity(thread, cores)


def context_switches(process_ids: Iterable[int]) -> int:
    """How often the threads that the processes have now have given up a core to wait, since those began."""
    switches = 0
    for process_id in process_ids:
        for status in Path(f"/proc/{process_id}/task").glob("*/status"):
            switches += int(
                re.findall(r"^voluntary_ctxt_switches:\s*(\d+)", status.read_text(), re.MULTILINE)[0]
            )
    return switches


def memory_mb(process_ids: Iterable[int]) -> float:
    """Proportional set size of these processes together: what they share counts once."""
    return sum(_sizes(process_id)["Pss"] for process_id in process_ids) / 1024


def private_mb(process_id: int) -> float:
    """What no other process has: given back when this one ends. Unlike the above, other programs do not change it."""
    sizes = _sizes(process_id)
    return (sizes["Private_Clean"] + sizes["Private_Dirty"]) / 1024


def _sizes(process_id: int) -> dict[str, int]:
    lines = Path(f"/proc/{process_id}/smaps_rollup").read_text().splitlines()[1:]
    return {name: int(rest.split()[0]) for name, _, rest in (line.partition(":") for line in lines)}


def processor_seconds(process_ids: Iterable[int]) -> float:
    """Of all threads that the processes have now, since those began; 0 where the system does not tell."""
    nanoseconds = 0
    for process_id in process_ids:
        for schedule in Path(f"/proc/{process_id}/task").glob("*/schedstat"):
            nanoseconds += int(schedule.read_text().split()[0])
    return nanoseconds / 1e9


def core_share(process_ids: Iterable[int], seconds: float) -> float:
    """Processor seconds per second of these processes together, over so many seconds from now."""
    watched = list(process_ids)
    before, began = processor_seconds(watched), time.perf_counter()
    time.sleep(seconds)
    return (processor_seconds(watched) - before) / (time.perf_counter() - began)


def bytes_to_port(port: int) -> tuple[int, int]:
    """(sent, received) so far on this process's own TCP connections to a port."""
    sent = received = 0
    for entry in os.listdir("/proc/self/fd"):
        try:
            if not os.readlink(f"/proc/self/fd/{entry}").startswith("socket:"):
                continue  # what is no socket would leave its copy open
            with socket.socket(fileno=os.dup(int(entry))) as copy:
                if copy.type == socket.SOCK_STREAM and copy.getpeername()[1] == port:
                    info = copy.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 256)
                    counts = struct.unpack_from("QQ", info, _TCP_INFO_BYTES)
                    sent, received = sent + counts[0], received + counts[1]
        except (OSError, IndexError, TypeError):  # closed by now, or without a peer
            continue
    return sent, received
