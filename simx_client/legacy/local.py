"""The functions that work in the client: connection, pause, header fields, packing.

Their names, parameters and sentences are in the table; a test compares both. They keep the legacy spelling
and, like all legacy functions, never raise for errors of the server or network.
"""

from __future__ import annotations

import atexit
import ctypes
import logging
import struct
import time
from typing import Any

from simx_client.calls.marshalling import Marshal
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.embedding import chosen_scene, embedded_in_process
from simx_client.connection.message_header import PROTOCOL_HEADER_VERSION, client_time, header_field
from simx_client.connection.pace import chosen_pace
from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.errors import ConnectionFailed
from simx_client.protocol import constants as c
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.kinds import to_bytes, to_floats, to_int32, to_ints
from simx_client.transport.endpoints import find_address
from simx_client.transport.lanes import open_link

from .files import simxTransferFile as simxTransferFile

logger = logging.getLogger(__name__)


def simxStart(
    connectionAddress: str,
    connectionPort: int,
    waitUntilConnected: bool,
    doNotReconnectOnceDisconnected: bool,
    timeOutInMs: int,
    commThreadCycleInMs: int,
) -> int:
    """Connect to the server at an address (host names too) and port, or to ``REALM@ROUTER`` and the router's
    port.

    Args:
        connectionAddress: host name or address, or ``REALM@ROUTER``.
        connectionPort: a negative one, which selected shared memory in V-REP, means its absolute value.
        waitUntilConnected: False returns an id at once and connects in the background.
        doNotReconnectOnceDisconnected: make one attempt only, and no new one after a loss.
        timeOutInMs: how long to repeat attempts. Negative: the time-out of this client's blocking calls
            instead, and 5000 ms to connect.
        commThreadCycleInMs: accepted without effect: calls are sent at once.

    Returns:
        The lowest free client id, from 0; -1 with one line in the log that says why.
    """
    address, port, waits, once, milliseconds, _ = _START.coerce(
        (
            connectionAddress,
            connectionPort,
            waitUntilConnected,
            doNotReconnectOnceDisconnected,
            timeOutInMs,
            commThreadCycleInMs,
        )
    )
    port = abs(port)  # negative: V-REP's shared memory at the port of that number
    if not 0 < port < 65536:
        logger.warning("no connection to %s:%d: the port must be 1..65535, or negative", address, port)
        return -1
    timeout = milliseconds / 1000 if milliseconds > 0 else DEFAULT_TIMEOUT
    attempt = timeout if waits else 0.0  # the background thread repeats attempts
    call_timeout = -milliseconds / 1000 if milliseconds < 0 else DEFAULT_TIMEOUT
    try:
        pace = chosen_pace()
        if (scene := chosen_scene()) is not None:
            server = "the simulation in this process"
            connection = embedded_in_process(scene, address, port, timeout=call_timeout, pace=pace)
        else:
            server = find_address(address, port)
            connection = Connection(
                lambda: open_link(server, connect_timeout=attempt, retry=not once, asked_port=port),
                where=f"{address}:{port}",
                timeout=call_timeout,
                may_reconnect=not once,
                pace=pace,
            )
    except ValueError as error:
        logger.warning("no connection to %s:%d: %s", address, port, error)
        return -1
    client_id = CLIENTS.add(connection)
    if client_id == -1:
        return -1
    if not waits:
        connection.connect_in_background()
        return client_id
    try:
        connection.connect(timeout)
    except ConnectionFailed as error:
        logger.warning("no connection: tried %s%s; %s", server, "" if scene else " over Zenoh", error)
        CLIENTS.discard(connection)
        return -1
    except BaseException:  # Ctrl-C: a script may continue and try again
        CLIENTS.discard(connection)
        raise
    return client_id


def simxFinish(clientID: int) -> None:
    """Close one connection after everything sent has been executed, or all connections with -1."""
    CLIENTS.remove(to_int32(clientID))


atexit.register(CLIENTS.end)


def simxGetConnectionId(clientID: int) -> int:
    """Return 1 after the first connection, one more after each reconnection; -1 while not connected."""
    connection = CLIENTS.get(clientID)
    return -1 if connection is None else connection.connection_id


def simxGetPingTime(clientID: int) -> tuple[int, int]:
    """Return (return code, milliseconds) of one blocking exchange; (0, 0) for an unknown client, as the
    original."""
    connection = CLIENTS.get(clientID)
    if connection is None:
        return 0, 0
    began = time.perf_counter()
    code = connection.paced_ping()
    milliseconds = round((time.perf_counter() - began) * 1000)
    return code & ~c.simx_return_remote_error_flag, milliseconds


def simxGetLastCmdTime(clientID: int) -> int:
    """Return the simulation time in ms of the reply that was fetched last; 0 while stopped."""
    connection = CLIENTS.get(clientID)
    return 0 if connection is None else connection.last_command_time_ms


def simxPauseCommunication(clientID: int, enable: bool) -> int:
    """Batch calls (True), then send them together (False). Pauses nest."""
    connection = CLIENTS.get(clientID)
    if connection is None:
        return c.simx_return_initialize_error_flag
    connection.pause(bool(enable))
    return c.simx_return_ok


def simxGetInMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return (1, value) of a header field of the newest reply, or (-1, 0). ``infoType`` is a
    simx_headeroffset_."""
    connection = CLIENTS.get(clientID)
    header = None if connection is None else connection.newest_header()
    value = None if header is None else header_field(header, to_int32(infoType))
    return (-1, 0) if value is None else (1, value)


def simxGetOutMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return (1, value) of a header field of the next outgoing message, or (-1, 0)."""
    connection = CLIENTS.get(clientID)
    if infoType == c.simx_headeroffset_version:
        return 1, PROTOCOL_HEADER_VERSION
    if infoType == c.simx_headeroffset_client_time:
        return 1, client_time()
    if infoType == c.simx_headeroffset_message_id and connection is not None:
        return 1, connection.message_id
    return -1, 0


def simxCreateBuffer(bufferSize: int) -> Any:
    """Return a ctypes pointer to this number of unsigned bytes, all 0; it keeps them alive."""
    buffer = (ctypes.c_ubyte * max(0, to_int32(bufferSize)))()
    return ctypes.cast(buffer, ctypes.POINTER(ctypes.c_ubyte))


def simxReleaseBuffer(buffer: Any) -> None:
    """Do nothing: Python frees the bytes with the last reference to the pointer."""


def simxPackInts(intList: Any) -> bytearray:
    """Pack integers as little-endian int32."""
    values = to_ints(intList)
    return bytearray(struct.pack(f"<{len(values)}i", *values))


def simxUnpackInts(intsPackedInString: Any) -> list[int]:
    """Unpack the result of simxPackInts; ignore trailing bytes."""
    data = _packed(intsPackedInString)
    return list(struct.unpack_from(f"<{len(data) // 4}i", data))


def simxPackFloats(floatList: Any) -> bytearray:
    """Pack numbers as little-endian float32."""
    values = to_floats(floatList)
    return bytearray(struct.pack(f"<{len(values)}f", *values))


def simxUnpackFloats(floatsPackedInString: Any) -> list[float]:
    """Unpack the result of simxPackFloats; ignore trailing bytes."""
    data = _packed(floatsPackedInString)
    return list(struct.unpack_from(f"<{len(data) // 4}f", data))


def _packed(value: Any) -> bytes:
    return value.encode("latin-1") if isinstance(value, str) else to_bytes(value)


def simxQuery(
    clientID: int, signalName: str, signalValue: Any, retSignalName: str, timeOutInMs: int
) -> tuple[int, bytearray]:
    """Set one string signal and wait for the answer in another.

    Returns:
        (0, answer); (2, empty) when no answer came within ``timeOutInMs``.
    """
    connection = CLIENTS.get(clientID)
    if connection is None:
        return c.simx_return_initialize_error_flag, bytearray()
    timeout = max(0, to_int32(timeOutInMs)) / 1000
    deadline = time.monotonic() + timeout
    connection.invoke(_CLEAR_STRING, (retSignalName,), c.simx_opmode_oneshot)
    connection.invoke(_TAKE_STRING, (retSignalName,), c.simx_opmode_remove)
    connection.invoke(_TAKE_STRING, (retSignalName,), c.simx_opmode_streaming)
    code = connection.blocking(
        _SET_STRING, _SET_STRING.coerce((signalName, signalValue)), min(timeout, connection.timeout)
    )
    if code:
        connection.invoke(_TAKE_STRING, (retSignalName,), c.simx_opmode_discontinue)
        return code, bytearray()
    while True:
        code, answer = connection.invoke(_TAKE_STRING, (retSignalName,), c.simx_opmode_buffer)
        if code == c.simx_return_ok:
            return code, answer
        if time.monotonic() >= deadline:
            connection.invoke(_TAKE_STRING, (retSignalName,), c.simx_opmode_discontinue)
            return c.simx_return_timeout_flag, bytearray()
        time.sleep(0.001)


_START = Marshal(BY_NAME["simxStart"])
_CLEAR_STRING = Marshal(BY_NAME["simxClearStringSignal"])
_TAKE_STRING = Marshal(BY_NAME["simxGetAndClearStringSignal"])
_SET_STRING = Marshal(BY_NAME["simxSetStringSignal"])
