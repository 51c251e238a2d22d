"""A network cable between two namespaces: ``python tun_cable.py NAMESPACE DEVICE NAMESPACE DEVICE``.

Two tun devices and this process between them, since not every kernel has veth or netem. Lines tell it what to do:
``cut`` loses every packet, ``deaf`` only those from the second end, ``mend`` ends both; ``delay 0.02`` holds each
packet up for this many seconds, ``lose 7`` drops every seventh. Ends with its standard input.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import selectors
import struct
import sys
import time
from collections import deque

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
CLONE_NEWNET = 0x40000000
LONGEST = 65536


def end_in(namespace: str, device: str) -> int:
    """A new tun device in a namespace, as a file descriptor."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open(f"/run/netns/{namespace}") as entered:
        if libc.setns(entered.fileno(), CLONE_NEWNET):
            raise OSError(ctypes.get_errno(), f"cannot enter {namespace}")
    end = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(end, TUNSETIFF, struct.pack("16sH22x", device.encode(), IFF_TUN | IFF_NO_PI))
    os.set_blocking(end, False)
    return end


class Cable:
    """The packets between two ends, and the effects of the cable on them."""

    def __init__(self, one: int, other: int) -> None:
        self.across = {one: other, other: one}
        self.deaf: set[int] = set()
        """Ends out of which nothing is taken any more."""
        self.delay = 0.0
        self.lose_every = 0
        self._count = 0
        self._on_the_way: deque[tuple[float, int, bytes]] = deque()

    def obey(self, word: str, *number: str) -> None:
        one, other = self.across
        if word in ("cut", "mend", "deaf"):
            self.deaf = {"cut": {one, other}, "mend": set(), "deaf": {other}}[word]
        elif word == "delay":
            self.delay = float(number[0])
        else:
            self.lose_every = int(number[0])

    def take(self, end: int) -> None:
        packet = os.read(end, LONGEST)
        if end in self.deaf:
            return
        self._count += 1
        if not self.lose_every or self._count % self.lose_every:
            self._on_the_way.append((time.monotonic() + self.delay, self.across[end], packet))

    def pass_on(self) -> float | None:
        """Hand over what is due; seconds until the next is."""
        while self._on_the_way:
            due, end, packet = self._on_the_way[0]
            if (left := due - time.monotonic()) > 0:
                return left
            self._on_the_way.popleft()
            with contextlib.suppress(OSError):  # the device is not up yet
                os.write(end, packet)
        return None


def main() -> None:
    cable = Cable(end_in(*sys.argv[1:3]), end_in(*sys.argv[3:5]))
    selector = selectors.DefaultSelector()
    for readable in (*cable.across, sys.stdin.fileno()):
        selector.register(readable, selectors.EVENT_READ)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while True:
        for key, _ in selector.select(cable.pass_on()):
            if key.fd in cable.across:
                with contextlib.suppress(OSError):
                    cable.take(key.fd)
                continue
            words = sys.stdin.readline().split()
            if not words:
                return
            cable.obey(*words)
            sys.stdout.write("done\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
