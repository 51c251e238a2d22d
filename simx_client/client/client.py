"""Provide ``Client``: a connection, and access to everything in the scene."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self, TypeVar, overload

from simx_client.calls.strict import Strict, misspelt
from simx_client.connection.calls import Calls
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.embedding import as_arguments
from simx_client.connection.exchange import connection_of
from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.protocol import constants as c

from .channel import Channel
from .opening import open_connection, open_embedded, split_port
from .scene.camera import Camera
from .scene.joints import Joint, Joints
from .scene.listing import Objects
from .scene.objects import Dummy, Object, SceneObject, Shape
from .scene.scene import Scene
from .scene.sensors import ForceSensor, ProximitySensor
from .servers import Servers
from .signals import Signals
from .simulation import Simulation
from .stepping import Stepping
from .watching import Watch

if TYPE_CHECKING:
    from collections.abc import Callable

    from simx_client.transport.direct import EmbeddedServer

S = TypeVar("S", bound=SceneObject)
T = TypeVar("T")


class Results(NamedTuple):
    """Results of a script function."""

    ints: list[int]
    floats: list[float]
    strings: list[str]
    buffer: bytes

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise misspelt(self, name)


def _close_embedded(connection: Connection, server: EmbeddedServer) -> None:
    CLIENTS.discard(connection)
    server.close()


class Client(Strict):
    """A client of one server; a context manager that closes the connection.

        with Client("127.0.0.1", 19997) as client:
            client.joint("UR5_joint1").target_position = 0.5

    Not thread-safe: each thread needs its own client. Legacy functions take its ``id``.
    """

    __slots__ = (
        "__weakref__",
        "_channel",
        "_close",
        "_connection",
        "_scene",
        "embedded_ports",
        "signals",
        "simulation",
    )

    def __init__(
        self, address: str = "127.0.0.1", port: int | None = None, *, timeout: float = DEFAULT_TIMEOUT
    ) -> None:
        """Connect to a server.

        Args:
            address: host, ``HOST:PORT``, or ``REALM@ROUTER:PORT`` for a simulator by its name behind a
                router.
            port: 19997 unless it is given here or in the address.
            timeout: time-out in seconds, to connect and for each answer.

        Raises:
            ConnectionFailed: with what was tried, what was found and what to do.
            ValueError: the address cannot be read.
        """
        connection = open_connection(*split_port(address, port), timeout)
        self._take(connection, timeout)
        # Closes when this client is garbage-collected, and at the end of the program.
        self._close = weakref.finalize(self, CLIENTS.discard, connection)

    @classmethod
    def of(cls, client_id: int) -> Client:
        """Return a client for a connection made by simxStart; simxFinish closes that connection.

        Raises:
            ValueError: no client has this id.
        """
        self = cls.__new__(cls)
        connection = connection_of(client_id)
        self._take(connection, connection.timeout)
        self._close = None
        return self

    @classmethod
    def embedded(
        cls,
        scene: str | os.PathLike[str] | None = None,
        *,
        timeout: float = DEFAULT_TIMEOUT,
        **settings: object,
    ) -> Self:
        """Start a simulation in this process and connect to it: calls take microseconds, and no port is opened.

            with Client.embedded("ur5_rg2_kinect", time_step=0.01) as client:
                client.simulation.start()

        The simulation ends with this client. Legacy functions take its ``id``. Each client has its own simulation.

        Args:
            scene: what ``simx-server`` takes: a V-REP, MJCF or URDF file, or the name of a shipped scene.
            timeout: time-out of calls in seconds.
            settings: flags of ``simx-server``, with underscores: ``speed="max"``, ``record="run.simx"``,
                ``port=19997`` to let other processes connect, ``view=8080`` for the web viewer.

        Raises:
            ConnectionFailed: the server is not installed, or the scene or a setting cannot be used.
        """
        connection, server = open_embedded(as_arguments(scene, settings), timeout)
        self = cls.__new__(cls)
        self._take(connection, timeout)
        self._close = weakref.finalize(self, _close_embedded, connection, server)
        self.embedded_ports = server.ports
        return self

    @staticmethod
    def many(addresses: Iterable[int | tuple[str, int]], *, timeout: float = DEFAULT_TIMEOUT) -> Servers:
        """Connect to several servers, by port on this host or by (host, port), to step them together.

            with Client.many([19997, 20000]) as servers:
                positions = servers.watch(lambda calls, place: [calls.simxGetJointPosition(joint)])

        Args:
            timeout: time-out for the answers of all servers together in seconds.

        Raises:
            ConnectionFailed: one of them cannot be reached; none stays connected.
        """
        return Servers.connect(addresses, timeout=timeout)

    def _take(self, connection: Connection, timeout: float) -> None:
        self._connection = connection
        self.embedded_ports = ()
        self._channel = Channel(connection, timeout)
        self._scene = Scene(self._channel)
        self.signals = Signals(self._channel)
        self.simulation = Simulation(self._channel, connection)

    embedded_ports: tuple[int, ...]
    """Ports of an embedded simulation by which other processes can connect; empty unless a setting names one."""

    _close: weakref.finalize[..., Client] | None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection; the simulation continues unchanged. Idempotent."""
        self._channel.is_closed = True
        if self._close is not None:
            self._close()

    def __repr__(self) -> str:
        """Return the state that is known without a request."""
        if not hasattr(self, "_channel"):
            return "<Client, never connected>"
        return f"<Client {self._channel.state}, id {self.id}>"

    @property
    def id(self) -> int:
        """Return the client id for legacy functions; -1 when closed."""
        return CLIENTS.id_of(self._connection)

    @property
    def timeout(self) -> float:
        """Return the time-out for each answer in seconds."""
        return self._channel.timeout

    @timeout.setter
    def timeout(self, seconds: float) -> None:
        self._channel.timeout = seconds

    # --- objects: each raises NoSuchObject, with the nearest names, or WrongKind ---------------------

    def object(self, name: str) -> Object:
        """Return an object of any kind by its name or path."""
        return self._scene.find(Object, name)

    def joint(self, name: str) -> Joint:
        """Return a joint by its name or path."""
        return self._scene.find(Joint, name)

    def joints(self, *names: str) -> Joints:
        """Return several joints, to read and set together."""
        return Joints(self._channel, [self.joint(name) for name in names])

    def camera(self, name: str) -> Camera:
        """Return a camera (V-REP: vision sensor) by its name or path."""
        return self._scene.find(Camera, name)

    def shape(self, name: str) -> Shape:
        """Return a shape by its name or path."""
        return self._scene.find(Shape, name)

    def dummy(self, name: str) -> Dummy:
        """Return a dummy by its name or path."""
        return self._scene.find(Dummy, name)

    def proximity_sensor(self, name: str) -> ProximitySensor:
        """Return a proximity sensor by its name or path."""
        return self._scene.find(ProximitySensor, name)

    def force_sensor(self, name: str) -> ForceSensor:
        """Return a force sensor by its name or path."""
        return self._scene.find(ForceSensor, name)

    @overload
    def objects(self) -> Objects[SceneObject]: ...
    @overload
    def objects(self, kind: type[S]) -> Objects[S]: ...
    def objects(self, kind: type[SceneObject] = SceneObject) -> Objects[Any]:
        """Return all objects of the scene with their classes: joints, cameras, shapes, …; one message.

            for joint in client.objects(Joint):
                print(joint.name, joint.position)

        Args:
            kind: a class of ``simx_client.client``; return only objects of this class.

        Returns:
            A sequence in the scene's order, which also takes a name: ``client.objects()["UR5_joint1"]``.

        Raises:
            TypeError: `kind` is not a class of objects.
        """
        if not (isinstance(kind, type) and issubclass(kind, SceneObject)):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"objects() takes a class such as simx_client.client.Joint, not {kind!r}")
        return self._scene.every(kind)

    # --- everything else -------------------------------------------------------------------------

    def call(
        self,
        function: str,
        script: str | SceneObject = "",
        ints: Sequence[int] = (),
        floats: Sequence[float] = (),
        strings: Sequence[str] = (),
        buffer: bytes = b"",
        *,
        script_type: int = c.sim_scripttype_childscript,
    ) -> Results:
        """Call a function of a script of the scene.

        Args:
            script: the object that carries the script, or its name.
            script_type: a sim_scripttype_ constant.

        Returns:
            The function's lists and buffer.

        Raises:
            RemoteError: no such script or function, or it failed; with the script's error.
        """
        name = script.name if isinstance(script, SceneObject) else script
        results = self._channel.request(
            lambda calls: calls.simxCallScriptFunction(
                name, script_type, function, ints, floats, strings, buffer
            )
        )
        return Results(results[0], results[1], results[2], bytes(results[3]))

    def batch(self, *, check: bool = True) -> AbstractContextManager[Calls]:
        """Note legacy calls in a ``with`` block, and send them as one message at its end.

            with client.batch() as calls:
                position = calls.simxGetJointPosition(joint)
                calls.simxSetJointTargetPosition(joint, 0.5)
            print(position.value)

        The server executes them in this order within one simulation step. A trigger makes a simulation step in its
        place: the calls after it read the new state.

        Args:
            check: raise if a call failed; otherwise read the code of each answer.

        Raises:
            RemoteError: the server refused calls. TimedOut, NotConnected: answers are missing.
        """
        return self._channel.noting(check=check)

    def together(self) -> AbstractContextManager[None]:
        """Send everything set in the ``with`` block as one message, applied in one simulation step.

        The message is sent at the end of the block, or with the first read in it. An exception drops the
        calls that were not sent.
        """
        return self._channel.batching()

    def watching(self, read: Callable[[], T]) -> Watch[T]:
        """Return a callable that reads many values of one instant with one message.

            read = client.watching(lambda: (arm.positions, ball.position))
            angles, position = read()

        Args:
            read: reads the values. The values that it read the last time are fetched together.
        """
        return Watch(self._channel, read)

    @overload
    def stepping(self) -> Stepping[None]: ...
    @overload
    def stepping(self, watch: Callable[[], T]) -> Stepping[T]: ...
    def stepping(self, watch: Callable[[], Any] = lambda: None) -> Stepping[Any]:
        """Turn on stepped mode for a ``with`` block: only ``step()`` advances the simulation.

            with client.stepping(lambda: (arm.positions, ball.position)) as step:
                angles, goal = step.latest
                arm.target_positions = angles + 0.01
                angles, goal = step()

        The block starts the simulation if it does not run; its end restores the state before: stopped, paused or
        running. Calls that set something wait for the step, so a simulation step costs one message.

        Args:
            watch: reads the values that ``step()`` returns. The values read the last time come with the step.

        Raises:
            RuntimeError: entered while another such block of this client is open.
        """
        return Stepping(self._channel, self.simulation, watch)

    def message(self, text: str) -> None:
        """Add a line to the server's status bar."""
        self._channel.send(lambda calls: calls.simxAddStatusbarMessage(text))
