"""Start, find and end a fleet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from simx_client.protocol.zenoh.keys import check_chunk

from .member import Member, Order
from .ray import NAMESPACE, FleetError
from .router import Router, is_loopback

ROUTER = "router"
ANSWERS_WITHIN = 10.0
"""Time-out in seconds for the answers of all actors."""

_HEAD = {"node:__internal_head__": 0.001}
"""Resource of the host of Ray's head: it outlives the others, or Ray itself is gone."""


class Wanted(NamedTuple):
    """A fleet to start."""

    name: str
    scene: str
    servers: int
    connect: tuple[str, ...]
    """Routers that exist; empty: the fleet has its own."""

    listen: str
    """Endpoint of the fleet's own router."""

    cpus: float
    """Share of a host that Ray reserves for each server, in cores."""

    flags: tuple[str, ...]
    ready_within: float


class Found(NamedTuple):
    """A fleet that exists."""

    endpoints: list[str]
    members: dict[str, Any]
    """Actors by realm."""


def up(ray: Any, wanted: Wanted) -> tuple[list[str], list[dict[str, Any]]]:
    """Start a fleet and wait until all its servers are ready.

    Returns:
        The endpoints of the routers by which clients reach it, and the descriptions of its servers.

    Raises:
        FleetError: the fleet exists, a server cannot start, or the cluster has no room; no server remains.
    """
    check_chunk(wanted.name)
    if list(_actors(ray, wanted.name)):
        raise FleetError(
            f"the fleet {wanted.name!r} exists; end it with: simx fleet down --name {wanted.name}"
        )
    endpoints = list(wanted.connect or (wanted.listen,))
    _check_reach(ray, endpoints)
    started: list[Any] = []
    try:
        if not wanted.connect:
            started.append(_router(ray, wanted))
            endpoints = _wait(ray, wanted, [started[0].describe.remote()])
        members = [_member(ray, wanted, number, endpoints) for number in range(wanted.servers)]
        started += members
        return endpoints, _wait(ray, wanted, [each.describe.remote() for each in members])
    except BaseException:
        for actor in started:
            ray.kill(actor)
        raise


def find(ray: Any, name: str) -> Found:
    """Return the actors of a fleet.

    Raises:
        FleetError: no fleet has this name; the text contains those that exist.
    """
    actors = dict(_actors(ray, name))
    if not actors:
        names = sorted({each["name"].partition("/")[0] for each in _named(ray)})
        others = f"there are {', '.join(names)}" if names else "there is none"
        raise FleetError(
            f"no fleet {name!r} in this cluster; {others}; start one with: simx fleet up SCENE --count N"
        )
    router = actors.pop(ROUTER, None)
    endpoint = answers(ray, {ROUTER: router.describe.remote()})[ROUTER] if router is not None else None
    return Found([endpoint] if endpoint else [], actors)


def answers(ray: Any, requests: dict[str, Any], timeout: float = ANSWERS_WITHIN) -> dict[str, Any]:
    """Return the answers by name; None for actors that do not answer now, such as those that restart."""
    names = {reference: name for name, reference in requests.items()}
    ready, _ = ray.wait(list(names), num_returns=len(names), timeout=timeout)
    found: dict[str, Any] = dict.fromkeys(requests)
    for reference in ready:
        try:
            found[names[reference]] = ray.get(reference)
        except ray.exceptions.RayActorError:
            continue
    return found


def down(ray: Any, name: str) -> int:
    """End all servers of a fleet and its router; return the number of servers.

    Raises:
        FleetError: no fleet has this name.
    """
    found = find(ray, name)
    answers(ray, {realm: actor.end.remote() for realm, actor in found.members.items()})
    for _, actor in list(_actors(ray, name)):
        ray.kill(actor)
    return len(found.members)


def _actors(ray: Any, fleet: str) -> Iterator[tuple[str, Any]]:
    """Yield the actors of a fleet by realm, and its router."""
    for each in _named(ray):
        of, _, name = each["name"].partition("/")
        if of == fleet:
            try:
                yield name, ray.get_actor(each["name"], namespace=NAMESPACE)
            except ValueError:  # it has ended meanwhile
                continue


def _named(ray: Any) -> list[dict[str, str]]:
    listed = ray.util.list_named_actors(all_namespaces=True)
    own = [each for each in listed if each["namespace"] == NAMESPACE and "/" in each["name"]]
    return sorted(own, key=lambda each: (len(each["name"]), each["name"]))


def _router(ray: Any, wanted: Wanted) -> Any:
    options = {"num_cpus": 0, "resources": _HEAD, "max_restarts": -1, "max_task_retries": -1}
    actor = ray.remote(Router).options(**options, **_detached(wanted, ROUTER))
    return actor.remote(wanted.listen)


def _member(ray: Any, wanted: Wanted, number: int, endpoints: Sequence[str]) -> Any:
    realm = f"{wanted.name}-{number}"
    order = Order(wanted.scene, realm, tuple(endpoints), wanted.flags, wanted.ready_within)
    options = {
        "num_cpus": wanted.cpus,
        "max_restarts": -1,
        "scheduling_strategy": "SPREAD",
        "max_concurrency": 4,  # a long answer must not delay the end
    }
    return ray.remote(Member).options(**options, **_detached(wanted, realm)).remote(order)


def _detached(wanted: Wanted, name: str) -> dict[str, Any]:
    return {"name": f"{wanted.name}/{name}", "namespace": NAMESPACE, "lifetime": "detached"}


def _wait(ray: Any, wanted: Wanted, requests: list[Any]) -> list[Any]:
    # Ray needs some seconds for a worker process where none is idle.
    _, missing = ray.wait(requests, num_returns=len(requests), timeout=wanted.ready_within + ANSWERS_WITHIN)
    if missing:
        free = ray.available_resources().get("CPU", 0.0)
        raise FleetError(
            f"{len(missing)} of {len(requests)} were not ready within {wanted.ready_within + ANSWERS_WITHIN:g} s; each "
            f"asks for {wanted.cpus:g} cores, and the cluster has {free:g} free: add hosts, or choose --cpus or --count"
        )
    try:
        return ray.get(requests)
    except ray.exceptions.RayActorError as error:
        reason = [line.strip() for line in str(error).splitlines() if "RuntimeError:" in line]
        raise FleetError(reason[-1].partition("RuntimeError:")[2].strip() if reason else str(error)) from None


def _check_reach(ray: Any, endpoints: Sequence[str]) -> None:
    hosts = {node["NodeManagerAddress"] for node in ray.nodes() if node["Alive"]}
    if len(hosts) > 1 and is_loopback(endpoints):
        raise FleetError(
            f"the cluster has {len(hosts)} hosts, and only one of them can reach a router at {', '.join(endpoints)}; "
            "use --listen tcp/0.0.0.0:7447, which opens it to the network, or --connect ENDPOINT for a router that "
            "all hosts reach"
        )
