"""Train the detector on what collect.py has taken: ``python examples/detect/train.py``.

Needs PyTorch, the extra ``detect``. It says what it reaches on the pictures that were held out. The weights lie in
detect_output/ball.pt then, and a curve beside them.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pictures
from collect import SET
from curve import draw
from measures import Measures, measure
from numpy.typing import NDArray

try:
    import torch
    from detector import SIZE, Detector, as_tensor, boxes_of, loss_of
except ModuleNotFoundError as missing:
    from simx_client.protocol.cli.installing import extra_line

    sys.exit(f"the package {missing.name} is not installed, which the detector needs: {extra_line('detect')}")

WEIGHTS = SET.parent / "ball.pt"
SURE = 0.5
"""From which presence on a ball counts as found."""
BATCH = 32
LEAST_SURE = 0.01
"""What is less sure than this does not change the mAP."""

Labels = list[NDArray[np.float64]]


def augmented(
    batch: pictures.CameraImage, labels: Labels, random: np.random.Generator
) -> tuple[torch.Tensor, Labels]:
    """Pictures as they could have been as well: the other way round, darker, brighter, of another tint.

    In half of the batches red, green and blue change places: what is round is to count, not what is cyan.
    """
    tint = torch.from_numpy(random.uniform(0.7, 1.3, (len(batch), 3, 1, 1))).float()
    tensor = (as_tensor(batch) * tint).clamp(0, 1)
    if random.random() < 0.5:
        tensor = tensor[:, random.permutation(3)]
    turned = torch.from_numpy(random.random(len(batch)) < 0.5)
    tensor[turned] = tensor[turned].flip(3)
    mirrored = [
        things * (-1, 1, 1, 1) + (1, 0, 0, 0) if turn else things
        for things, turn in zip(labels, turned.tolist(), strict=True)
    ]
    return tensor, mirrored


def evaluate(detector: Detector, taken: pictures.CameraImage, labels: Labels) -> Measures:
    """Of pictures it has not learned from, one would hope."""
    detector.eval()
    found: Labels = []
    with torch.inference_mode():
        for first in range(0, len(taken), BATCH):
            found += boxes_of(detector(as_tensor(taken[first : first + BATCH])), LEAST_SURE)
    return measure(found, labels, SURE)


def train(folder: Path, epochs: int, seed: int) -> tuple[Detector, list[float], list[Measures]]:
    """Learn from a set; gives also the mean loss and the measures after each epoch.

    Raises:
        FileNotFoundError: there are no pictures. OSError: one cannot be read.
    """
    # A network this small keeps one core busy; two threads of it mostly wait for each other on a busy machine.
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    taken, labels = pictures.load(folder, "train", SIZE)
    held_out = pictures.load(folder, "val", SIZE)
    detector = Detector()
    batches = -(-len(taken) // BATCH)
    optimizer = torch.optim.AdamW(detector.parameters(), weight_decay=0.01)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 4e-3, total_steps=epochs * batches)
    losses, measures = [], []
    for epoch in range(1, epochs + 1):
        detector.train()
        total = 0.0
        for chosen in np.array_split(random.permutation(len(taken)), batches):
            batch, things = augmented(taken[chosen], [labels[place] for place in chosen], random)
            loss = loss_of(detector(batch), things)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += loss.item() * len(chosen)
        losses.append(total / len(taken))
        measures.append(evaluate(detector, *held_out))
        print(f"epoch {epoch:3} of {epochs}: loss {losses[-1]:.3f}, {measures[-1]}", flush=True)
    return detector, losses, measures


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Train a small YOLO on pictures of a ball.")
    parser.add_argument("--folder", type=Path, default=SET, help=f"the pictures ({SET})")
    parser.add_argument("--weights", type=Path, default=WEIGHTS, help=f"where the weights go ({WEIGHTS})")
    parser.add_argument("--epochs", type=int, default=40, help="how often it sees each picture (40)")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    began = time.perf_counter()
    try:
        detector, losses, measures = train(chosen.folder, chosen.epochs, chosen.seed)
    except OSError as problem:
        sys.exit(f"train.py: {problem}")
    minutes = (time.perf_counter() - began) / 60
    detector.save(chosen.weights)
    count = sum(parameter.numel() for parameter in detector.parameters())
    title = f"{count:,} parameters, {minutes:.1f} minutes; held out: {measures[-1]}"
    draw(chosen.weights.with_suffix(".png"), losses, [each.map50 for each in measures], title)
    print(f"{title}; weights in {chosen.weights}, curve beside them")
    return 0


if __name__ == "__main__":
    sys.exit(main())
