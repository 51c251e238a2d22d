"""Feeds the server what means no good: `python tests/fuzz/run.py TARGET CASES [SEED]`.

TARGET: codec, scenes, vrep (coverage-guided where atheris is installed, else random), files, calls, results, lua,
peers, originals, zmq, sockets, costs.
Nothing is written into the repository. Exit code 0: nothing found; 1: the case is told, with how to run it again:
`python tests/fuzz/run.py TARGET -r HEX`.
"""

from __future__ import annotations

import logging
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path[:0] = [
    str(Path(__file__).resolve().parents[1] / "support"),
    str(Path(__file__).resolve().parents[1] / "support" / "worlds"),
    str(Path(__file__).resolve().parents[1] / "support" / "gateways"),
    str(Path(__file__).resolve().parents[1] / "support" / "vrep_files"),
    *map(str, Path(__file__).resolve().parents[1:3]),
]

LENGTHS = (8, 20, 60, 256)
"""Most bytes of a random case."""


def _prepare(target: str, folder: Path) -> tuple[Callable[[bytes], None], tuple[bytes, ...]]:
    """What takes one case, and seeds."""
    if target == "codec":
        from fuzz import codec

        return (lambda data: codec.one(data, folder)), codec.SEEDS
    if target == "files":
        from fuzz.files import Sender

        return Sender(folder).one, (b"",)
    if target == "vrep":
        from fuzz.vrep import Reader, bases

        return Reader().one, tuple(bytes([n, 2]) + bytes(12) for n in range(len(bases())))
    from fuzz.scenes import Loader

    return Loader(folder).one, tuple(bytes([n]) for n in range(3))


def _random_cases(
    one: Callable[[bytes], None], seeds: tuple[bytes, ...], cases: int, seed: int, noted: Path
) -> None:
    """Cases from seeds with some bytes changed, and from nothing; the present one is noted in case it ends us."""
    source = random.Random(seed)
    for _ in range(cases):
        data = (
            bytearray(source.choice(seeds))
            if source.random() < 0.5
            else bytearray(source.randbytes(source.randrange(source.choice(LENGTHS))))
        )
        for _ in range(source.choice((0, 1, 1, 2, 4, 16))):
            at = source.randrange(len(data) + 1)
            match source.randrange(3):
                case 0:
                    data[at : at + 1] = source.randbytes(1)
                case 1:
                    data[at:at] = source.randbytes(source.randrange(1, 12))
                case _:
                    del data[at : at + source.randrange(1, 4)]
        if noted.name in ("scenes", "files"):  # MuJoCo may end this process
            noted.write_bytes(bytes(data))
        try:
            one(bytes(data))
        except BaseException:
            noted.write_bytes(bytes(data))
            raise


def _guided(target: str, cases: int, seed: int, folder: Path) -> None:
    """Atheris leads; it ends the process itself."""
    import atheris

    with atheris.instrument_imports(  # pyright: ignore[reportAttributeAccessIssue] - made at run time
        include=[
            "simx_client.protocol",
            "simx_server.scene",
            "simx_server.files.workspace",
            "simx_server.limits",
        ]
    ):
        one, seeds = _prepare(target, folder)
    corpus = folder / "corpus"
    corpus.mkdir()
    for number, each in enumerate(seeds):
        (corpus / str(number)).write_bytes(each)
    options = [
        f"-runs={cases}",
        f"-seed={seed}",
        "-max_len=4096",
        f"-artifact_prefix={folder}/",
        "-rss_limit_mb=4096",
        "-timeout=30",
        "-verbosity=1",
    ]
    atheris.Setup([sys.argv[0], *options, str(corpus)], one)
    atheris.Fuzz()


def _child(target: str, cases: int, seed: int, folder: Path, way: str) -> None:
    logging.disable(logging.WARNING)
    os.chdir(folder)
    if way == "guided":
        _guided(target, cases, seed, folder)
    else:
        _random_cases(*_prepare(target, folder), cases, seed, folder / target)


def _bytes_target(target: str, cases: int, seed: int, way: str) -> int:
    with tempfile.TemporaryDirectory() as name:
        began = time.monotonic()
        command = [sys.executable, __file__, target, str(cases), str(seed), "--in", name, "--way", way]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        seconds = time.monotonic() - began
        if done.returncode == 0:
            last = [line for line in done.stderr.splitlines() if "cov:" in line][-1:]
            sys.stdout.write(
                f"{target}: {cases} cases ({way}) in {seconds:.0f} s, nothing found {' '.join(last)}\n"
            )
            return 0
        found = [
            *Path(name).glob("crash-*"),
            *Path(name).glob("timeout-*"),
            *Path(name).glob("oom-*"),
            Path(name, target),
        ]
        data = next((path.read_bytes() for path in found if path.is_file()), b"")
        sys.stdout.write(
            f"{target}: found after {seconds:.0f} s, exit code {done.returncode}\n"
            f"{done.stdout[-2000:]}\n{done.stderr[-1000:]}\n"
        )
        sys.stdout.write(f"again: {Path(__file__).name} {target} -r {data.hex()}\n")
        return 1


def _hypothesis_target(target: str, cases: int, seed: int) -> int:
    """Cases are calls, or results."""
    from fuzz import attacks

    with tempfile.TemporaryDirectory() as name:
        began = time.monotonic()
        done = attacks.run(target, cases, seed, Path(name))
        sys.stdout.write(f"{target}: {done} cases in {time.monotonic() - began:.0f} s, nothing found\n")
    return 0


def _peers_target(target: str, cases: int, seed: int) -> int:
    from fuzz import originals, peers, sockets, zmq_clients
    from fuzz.costs import messages as message_costs

    run = {
        "peers": peers, "originals": originals, "zmq": zmq_clients, "sockets": sockets, "costs": message_costs,
    }[target].run  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        began = time.monotonic()
        seen = run(cases, seed, Path(name))
        sys.stdout.write(
            f"{target}: {cases} cases in {time.monotonic() - began:.0f} s, nothing found; {seen}\n"
        )
    return 0


def main(argv: list[str]) -> int:
    target, amount, *rest = argv
    if amount == "-r":
        with tempfile.TemporaryDirectory() as name:
            _prepare(target, Path(name))[0](bytes.fromhex(rest[0]))
        return 0
    cases, seed = int(amount), int(rest[0]) if rest else 1
    if "--in" in rest:
        _child(target, cases, seed, Path(rest[rest.index("--in") + 1]), rest[-1])
        return 0
    if target in ("peers", "originals", "zmq", "sockets", "costs"):
        return _peers_target(target, cases, seed)
    if target not in ("codec", "scenes", "files", "vrep"):
        return _hypothesis_target(target, cases, seed)
    if target == "files":  # what they do is done in a process of its own, where nobody counts the branches
        return _bytes_target(target, cases, seed, "random")
    try:
        import atheris  # noqa: F401 # pyright: ignore[reportMissingImports]
    except ImportError:
        return _bytes_target(target, cases, seed, "random")
    return _bytes_target(target, cases, seed, "random" if "--random" in rest else "guided")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
