"""A server on a thread of the test's process that is a ROS 2 node and the router, and plain Zenoh peers of it.

The peers know nothing of the gateway's code: their keys, hashes and attachments are written out here.
"""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import zenoh
from loopback import LoopbackTransport
from real_world import RealWorld
from routers import free_port

from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_server.gateways.ros2.gateway import Ros2Gateway, Ros2Options
from simx_server.gateways.ros2.wire.names import Distribution, Place
from simx_server.gateways.ros2.wire.session import Router
from simx_server.ros2_messages import BUILT_IN, BY_NAME, SERVICES

TIMEOUT = 30.0
"""Seconds until something that does not come fails the test."""

JOINT_STATE = (
    "sensor_msgs::msg::dds_::JointState_/"
    "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
)
CLOCK = (
    "rosgraph_msgs::msg::dds_::Clock_/RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"
)
TF = "tf2_msgs::msg::dds_::TFMessage_/RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
IMAGE = (
    "sensor_msgs::msg::dds_::Image_/RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"
)
CAMERA_INFO = (
    "sensor_msgs::msg::dds_::CameraInfo_/"
    "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"
)
TRIGGER = (
    "std_srvs::srv::dds_::Trigger_/RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
)
SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="5 5 0.1" rgba="0.4 0.5 0.6 1"/>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" range="-3 3"/>
      <geom name="upper" type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03"/>
      <body name="forearm" pos="0 0 -0.4">
        <joint name="elbow" axis="0 1 0" range="-3 3"/>
        <geom name="lower" type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02"/>
        <site name="tip" pos="0 0 -0.3"/>
        <body name="wheel_holder" pos="0.1 0 0">
          <joint name="wheel" axis="0 1 0"/><geom type="cylinder" size="0.03 0.01" mass="0.01"/>
        </body>
      </body>
    </body>
    <body name="box" pos="1 0 0.5"><freejoint/><geom name="cuboid" type="box" size="0.1 0.1 0.1" rgba="1 0 0 1"/></body>
    <body name="stand" pos="2 0 0.5" euler="0 0 1.5708">
      <geom type="box" size="0.1 0.1 0.1" rgba="0 1 0 1"/>
      <camera name="eye" pos="0 0 1" xyaxes="0 -1 0 0.3 0 1" resolution="64 48" fovy="60" output="rgb"/>
    </body>
  </worldbody>
  <actuator>
    <position name="shoulder" joint="shoulder" kp="5000" kv="300"/>
    <position name="elbow" joint="elbow" kp="2000" kv="100"/>
    <velocity name="wheel" joint="wheel" kv="0.1"/>
  </actuator>
</mujoco>
"""


class Sent(NamedTuple):
    """A message as it came."""

    key: str
    payload: bytes
    attachment: bytes

    @property
    def number(self) -> int:
        return struct.unpack_from("<q", self.attachment)[0]

    @property
    def value(self) -> dict[str, Any]:
        """The message, decoded."""
        dds_type = self.key.split("/")[-2]
        return BY_NAME[dds_type.replace("::dds_::", "/").replace("::", "/").rstrip("_")].decode(self.payload)

    @property
    def stamp(self) -> float:
        """Seconds of the header's stamp."""
        return seconds(self.value["header"]["stamp"])


def seconds(stamp: dict[str, int]) -> float:
    return stamp["sec"] + stamp["nanosec"] * 1e-9


def attachment(number: int = 1, gid: bytes = bytes(range(16))) -> bytes:
    """The 33 bytes, as the reference lists them."""
    return struct.pack("<qqB", number, time.time_ns(), 16) + gid


class Peer:
    """A Zenoh session that does what a ROS 2 node would do."""

    def __init__(self, port: int, mode: str = "client") -> None:
        config = zenoh.Config()
        for path, value in (
            ("mode", f'"{mode}"'),
            ("connect/endpoints", f'["tcp/127.0.0.1:{port}"]'),
            ("scouting/multicast/enabled", "false"),
            ("timestamping/enabled", "true"),
        ):
            config.insert_json5(path, value)
        self.session = zenoh.open(config)
        self._changed = threading.Condition()
        self._messages: dict[str, list[Sent]] = {}
        self._tokens: set[str] = set()
        self._kept: list[Any] = []

    def listen(self, key: str, *, is_late: bool = False) -> None:
        """Subscribe to a key; `is_late`: as a transient-local subscriber, which wants what was sent before."""

        def keep(sample: zenoh.Sample) -> None:
            data = b"" if sample.attachment is None else sample.attachment.to_bytes()
            with self._changed:
                sent = Sent(str(sample.key_expr), sample.payload.to_bytes(), data)
                self._messages.setdefault(key, []).append(sent)
                self._changed.notify_all()

        if is_late:
            import zenoh.ext

            history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
            self._kept.append(zenoh.ext.declare_advanced_subscriber(self.session, key, keep, history=history))
        else:
            self._kept.append(self.session.declare_subscriber(key, keep))

    def watch(self, domain: int = 0) -> None:
        """Watch the graph of a domain."""

        def keep(sample: zenoh.Sample) -> None:
            with self._changed:
                change = self._tokens.discard if sample.kind == zenoh.SampleKind.DELETE else self._tokens.add
                change(str(sample.key_expr))
                self._changed.notify_all()

        graph = f"@ros2_lv/{domain}/**"
        self._kept.append(self.session.liveliness().declare_subscriber(graph, keep, history=True))

    def wait_for_token(self, is_wanted: Callable[[str], bool]) -> str:
        """Return a token of the graph."""
        with self._changed:
            assert self._changed.wait_for(lambda: any(map(is_wanted, self._tokens)), TIMEOUT)
            return next(filter(is_wanted, self._tokens))

    def wait_for_no_token(self, is_meant: Callable[[str], bool] = lambda _: True) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: not any(map(is_meant, self._tokens)), TIMEOUT)

    @property
    def tokens(self) -> set[str]:
        with self._changed:
            return set(self._tokens)

    def got(self, key: str) -> list[Sent]:
        """Return all messages so far."""
        with self._changed:
            return list(self._messages.get(key, ()))

    def next(self, key: str, is_wanted: Callable[[Sent], bool] = lambda _: True) -> Sent:
        """Return the first message of a key that is wanted, and forget those before."""
        found: list[Sent] = []

        def look() -> bool:
            waiting = self._messages.get(key, [])
            while waiting and not found:
                if is_wanted(sent := waiting.pop(0)):
                    found.append(sent)
            return bool(found)

        with self._changed:
            assert self._changed.wait_for(look, TIMEOUT), f"nothing more of {key}"
        return found[0]

    def put(self, key: str, payload: bytes, data: bytes | None = None) -> None:
        block = zenoh.CongestionControl.BLOCK  # a machine under load must not lose messages of a test
        attached = attachment() if data is None else data
        self.session.put(key, payload, attachment=attached, congestion_control=block)

    def command(self, names: list[str], key: str = f"0/joint_command/{JOINT_STATE}", **arrays: Any) -> None:
        """Send a JointState."""
        self.put(key, BY_NAME["sensor_msgs/msg/JointState"].encode({"name": names, **arrays}))

    def ask(
        self,
        key: str,
        payload: bytes,
        data: bytes | None,
        target: zenoh.QueryTarget = zenoh.QueryTarget.ALL_COMPLETE,
    ) -> list[tuple[bytes, bytes]]:
        """Call a service; return payload and attachment of each answer."""
        replies = self.session.get(
            key,
            payload=payload,
            attachment=data,
            target=target,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=TIMEOUT,
        )
        found: list[tuple[bytes, bytes]] = []
        for reply in replies:
            assert reply.ok is not None
            assert reply.ok.attachment is not None
            found.append((reply.ok.payload.to_bytes(), reply.ok.attachment.to_bytes()))
        return found

    def trigger(self, name: str, key: str = "0/simx") -> dict[str, Any]:
        """Call a service of std_srvs/Trigger."""
        ((payload, _),) = self.ask(f"{key}/{name}/{TRIGGER}", bytes.fromhex("0001000000"), attachment())
        return SERVICES["std_srvs/srv/Trigger"].response.decode(payload)

    def call_standard(self, kind: str, name: str, /, **request: Any) -> dict[str, Any]:
        """Call a service of simulation_interfaces."""
        return self.call(f"simulation_interfaces/srv/{kind}", name, request)

    def call(
        self, kind: str, name: str, request: Mapping[str, Any], *, is_older: bool = False
    ) -> dict[str, Any]:
        """Call a service; `is_older`: with the types of an earlier release of its package."""
        service = (BUILT_IN.older.services if is_older else SERVICES)[kind]
        key = f"0/{name}/{service.dds_name}/{service.hash}"
        ((payload, _),) = self.ask(key, service.request.encode(request), attachment())
        return service.response.decode(payload)

    def close(self) -> None:
        self.session.close()


class Ros2World:
    """The server, its node, and peers."""

    def __init__(self, world: RealWorld, options: Ros2Options) -> None:
        self.world, self.options = world, options
        self.loop, self.simulation = world.loop, world.simulation
        self.gateway = Ros2Gateway(self.loop.service, options)
        self.port = int(options.router.endpoint.rpartition(":")[2])
        self._peers: list[Peer] = []
        self._thread = threading.Thread(target=self.loop.run, name="test-server")
        self._thread.start()
        if options.router.is_self:
            self.wait_until(lambda: self.gateway.is_declared)

    def client(self) -> int:
        """Return the id of a client of the remote API, which leaves the loop to its thread."""
        link = LoopbackTransport(self.loop, name="own", port=19997, turns=False)
        made = Connection(lambda: link, where=link.client, timeout=TIMEOUT)
        number = CLIENTS.add(made)
        made.connect(TIMEOUT)
        return number

    def peer(self, mode: str = "client") -> Peer:
        peer = Peer(self.port, mode)
        self._peers.append(peer)
        return peer

    def on_server(self, question: Callable[[], Any]) -> Any:
        """Return what a function returns on the server's thread."""
        answers: list[Any] = []
        done = threading.Event()

        def ask() -> None:
            answers.append(question())
            done.set()

        self.loop.service.queue.post(ask)
        assert done.wait(TIMEOUT)
        return answers[0]

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition comes true on the server's thread; each look follows a turn of its loop."""
        end = time.monotonic() + TIMEOUT
        while not self.on_server(condition):
            assert time.monotonic() < end

    def close_peers(self) -> None:
        for peer in self._peers:
            peer.close()
        self._peers.clear()

    def close(self) -> None:
        self.loop.service.ending.request()
        self._thread.join(TIMEOUT)
        self.close_peers()
        self.gateway.close()
        self.world.close()


@contextmanager
def ros2_world(
    folder: Path,
    *,
    scene: str | Path = SCENE,
    place: Place | None = None,
    router: Router | None = None,
    distribution: Distribution = Distribution.NEWER,
    speed: float = float("inf"),
    own: Mapping[str, str] | None = None,
) -> Iterator[Ros2World]:
    """Open a server for a test: by default as the router, on a free port.

    Args:
        scene: text of a scene, or the path of one.
        own: texts of definitions of further types, by name.
    """
    path = scene
    if not isinstance(path, Path):
        path = folder / "scene.xml"
        path.write_text(str(scene), encoding="utf-8")
    options = Ros2Options(
        place=place or Place(),
        router=router or Router(f"tcp/127.0.0.1:{free_port()}", is_self=True),
        distribution=distribution,
    )
    world = RealWorld(path, speed=speed)
    world.loop.service.world.ros2_topics.add_types(own or {})
    opened = Ros2World(world, options)
    try:
        yield opened
    finally:
        opened.close()
