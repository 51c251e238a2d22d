"""Files of the client: simxTransferFile, and the functions that load a scene, a model or a UI from the
client's disk.

The file is sent ahead in a separate call. The server keeps it for the loading call that follows. So every
operation mode works as usual, and the key stays that of the given path.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from simx_client.calls.marshalling import Shape
from simx_client.calls.operation_modes import MODE_MASK
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol import constants as c
from simx_client.protocol.commands import BY_NAME, CARRIED
from simx_client.protocol.files import MAX_FILE, is_vrep_name, twins
from simx_client.protocol.kinds import to_int32, to_text

logger = logging.getLogger(__name__)

FILE_IS_HERE = 1
"""Option bit 0 of the loading functions."""

_SENDING = (
    c.simx_opmode_oneshot,
    c.simx_opmode_blocking,
    c.simx_opmode_streaming,
    c.simx_opmode_oneshot_split,
    c.simx_opmode_streaming_split,
)

_TRANSFER = Shape(BY_NAME["simxTransferFile"])
_STORE, _LEND = (Shape(command) for command in CARRIED)


def simxTransferFile(
    clientID: int, filePathAndName: str, fileName_serverSide: str, timeOut: int, operationMode: int
) -> int:
    """Copy a local file into the server's workspace.

    Args:
        filePathAndName: path of the local file.
        fileName_serverSide: relative to the workspace; missing folders in it are created.
        timeOut: time-out of a blocking call in milliseconds; 0 or less: as for other calls.

    Returns:
        The return code; 32 without sending if the local file cannot be read or is larger than 64 MiB.
    """
    connection = CLIENTS.get(clientID)
    if connection is None:
        return c.simx_return_initialize_error_flag
    _, path, name, milliseconds, mode = _TRANSFER.coerce(
        (clientID, filePathAndName, fileName_serverSide, timeOut, operationMode)
    )
    data: bytes | None = b""
    if mode != c.simx_opmode_remove:
        data = _read("simxTransferFile", Path(path))
    if data is None:
        return c.simx_return_local_error_flag
    if mode & MODE_MASK == c.simx_opmode_blocking:
        return connection.blocking(_STORE, [name, data], milliseconds / 1000 if milliseconds > 0 else None)
    return connection.invoke(_STORE, (name, data), mode)


def invoke_loading(shape: Shape, client_id: Any, arguments: tuple[Any, ...], mode: int) -> Any:
    """Execute a generated function that loads a file; its arguments are path and options."""
    connection = CLIENTS.get(client_id)
    if connection is None:
        return shape.failure(c.simx_return_initialize_error_flag)
    path, options = to_text(arguments[0]), to_int32(arguments[1])
    is_default = (
        not path and shape.command.name == "simxLoadScene"
    )  # V-REP's default scene, which has no file
    if not is_default and options & FILE_IS_HERE and shape.mode(mode) & MODE_MASK in _SENDING:
        code = _lend(connection, shape.command.name, path)
        if code:
            return shape.failure(code)
    return connection.invoke(shape, arguments, mode)


def _lend(connection: Connection, name: str, path: str) -> int:
    """Send the file ahead; return a return code."""
    file = _twin(Path(path))
    data = _read(name, file)
    if data is None:
        return c.simx_return_local_error_flag
    return connection.blocking(_LEND, _LEND.coerce((path, file.name, data)))


def _twin(path: Path) -> Path:
    """Return the file that is sent for a path: the file itself where the server reads it, else one of the same stem.

    V-REP's custom UIs and CoppeliaSim's XML files cannot be read; a missing file may have a replacement too.
    """
    if is_vrep_name(path.name) and path.is_file():
        return path
    for name in twins(path.name):
        twin = path.with_name(name)
        if twin.is_file():
            why = "cannot be read" if path.is_file() else "is not there"
            logger.info("'%s' %s, '%s' beside it is sent in its place", path, why, name)
            return twin
    return path


def _read(name: str, path: Path) -> bytes | None:
    """Return the whole file; None if it cannot be read, with the reason in the log."""
    try:
        size = path.stat().st_size
        if size <= MAX_FILE:
            return path.read_bytes()
        problem = f"it has {size} bytes, and at most {MAX_FILE} travel; put it on the server's side yourself"
    except (OSError, ValueError) as error:
        problem = getattr(error, "strerror", None) or str(error)
    logger.warning("%s sent nothing: '%s' cannot be read: %s", name, path, problem)
    return None
