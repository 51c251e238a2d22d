"""A network cable between two namespaces: ``python tests/tun_cable.py NAMESPACE DEVICE NAMESPACE DEVICE``.

Two tun devices and this process between them, since not every kernel has veth. The line ``cut`` makes it lose every
packet, ``mend`` ends that. Ends with its standard input.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import selectors
import struct
import sys

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


def main() -> None:
    one, other = end_in(*sys.argv[1:3]), end_in(*sys.argv[3:5])
    across, is_cut = {one: other, other: one}, False
    selector = selectors.DefaultSelector()
    for readable in (one, other, sys.stdin.fileno()):
        selector.register(readable, selectors.EVENT_READ)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while True:
        for key, _ in selector.select():
            if key.fd not in across:
                word = sys.stdin.readline().strip()
                if not word:
                    return
                is_cut = word == "cut"
                sys.stdout.write("done\n")
                sys.stdout.flush()
                continue
            try:
                packet = os.read(key.fd, LONGEST)
                if not is_cut:
                    os.write(across[key.fd], packet)
            except OSError:  # the device is not up yet
                continue


if __name__ == "__main__":
    main()
