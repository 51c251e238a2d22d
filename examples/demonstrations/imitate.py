"""Fifty demonstrations, a dataset, a network that imitates them: ``python examples/demonstrations/imitate.py``.

Needs PyTorch, of the extra ``learning``.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import torch
from cell import ACTIONS, OBSERVATIONS, Cell
from network import Imitator, load
from scripted_operator import Operator

from simx_server.app.export.command import main as export

UNSEEN = 10_000
"""The first seed of evaluations."""


def demonstrate(recording: Path, count: int, seed: int) -> int:
    """Record episodes of the scripted operator; return how many of them succeeded."""
    cell = Cell(recording)
    try:
        return sum(cell.episode(seed + number, Operator(seed + number)) for number in range(count))
    finally:
        cell.close()


def evaluate(network: Imitator, count: int) -> int:
    """Return in how many episodes with unseen places of cube and mark the network succeeded."""
    cell = Cell()
    try:
        return sum(cell.episode(UNSEEN + number, network.pilot) for number in range(count))
    finally:
        cell.close()


def imitate(folder: Path, *, demonstrations: int, epochs: int, trials: int, seed: int) -> tuple[int, int]:
    """Demonstrate, export, learn, evaluate; return successes of the demonstrations and of the network."""
    torch.set_num_threads(1)  # the network is small: two threads mostly wait for each other
    began = time.process_time()

    def say(text: str) -> None:
        print(f"{text}; {time.process_time() - began:.0f} s of processor time so far", flush=True)

    recording, dataset = folder / "run.simxlog", folder / "demonstrations"
    shown = demonstrate(recording, demonstrations, seed)
    say(f"{shown} of {demonstrations} demonstrations succeeded")
    words = [
        str(recording),
        "--npz",
        str(dataset),
        "--successes",
        "--observe",
        *OBSERVATIONS,
        "--act",
        *ACTIONS,
    ]
    if code := export(words):
        raise SystemExit(code)
    observed, velocities, is_open = load(dataset)
    network = Imitator(seed)
    loss = network.fit(observed, velocities, is_open, epochs=epochs)
    say(f"learned from {len(observed)} steps, loss {loss:.4f}")
    reached = evaluate(network, trials)
    say(f"the network succeeded in {reached} of {trials} episodes that it has not seen")
    return shown, reached


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A network imitates demonstrations of a pick and place.")
    parser.add_argument(
        "--demonstrations", type=int, default=50, metavar="N", help="episodes to learn from (50)"
    )
    parser.add_argument("--epochs", type=int, default=100, help="passes over their steps (100)")
    parser.add_argument("--trials", type=int, default=50, help="episodes of the evaluation (50)")
    parser.add_argument("--seed", type=int, default=1, help="of the demonstrations and the network (1)")
    options = parser.parse_args()
    with TemporaryDirectory(prefix="demonstrations-") as folder:
        imitate(Path(folder), **vars(options))
