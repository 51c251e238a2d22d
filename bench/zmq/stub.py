"""A server of the ZeroMQ remote API with nothing behind it: ``python -m bench.zmq.stub``.

It is what the protocol itself costs: a REP socket, as CoppeliaSim has, that reads each message and answers at once.
"""

from __future__ import annotations

import sys
import threading

import cbor2
import zmq

ANSWER = [1.0, 2.0, 3.0]
"""Of every function: a position."""


def serve() -> None:
    """Answer until standard input ends."""
    context = zmq.Context()
    socket = context.socket(zmq.REP)
    port = socket.bind_to_random_port("tcp://127.0.0.1")
    sys.stdout.write(f"ready tcp/127.0.0.1:{port}\n")
    sys.stdout.flush()
    threading.Thread(target=_answer, args=(socket,), daemon=True).start()
    sys.stdin.read()


def _answer(socket: zmq.Socket[bytes]) -> None:
    info = {"ret": [{"getObjectPosition": {"func": {}}}]}
    while True:
        function = cbor2.loads(socket.recv())["func"]
        socket.send(cbor2.dumps(info if function == "zmqRemoteApi.info" else {"ret": [ANSWER]}))


if __name__ == "__main__":
    serve()
