"""A small network that imitates: from what is observed, the velocity of the tip and whether the gripper is open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from cell import Numbers
from scripted_operator import SPEED
from torch import nn

HIDDEN = 128
BATCH = 256


class Imitator(nn.Module):
    """Three layers. It sees where cube and mark are from the tip, since the way there does not depend on the place."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        torch.manual_seed(seed)
        self.mean, self.deviation = nn.Buffer(torch.zeros(9)), nn.Buffer(torch.ones(9))
        self.layers = nn.Sequential(
            nn.Linear(9, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, HIDDEN), nn.ReLU(),
            nn.Linear(HIDDEN, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, 4),
        )  # fmt: skip

    def forward(self, observed: torch.Tensor) -> torch.Tensor:
        """Return (n, 4): shares of the speed along x, y and z, and a number that is above 0 to open the gripper."""
        return self.layers((features(observed) - self.mean) / self.deviation)

    def fit(self, observed: Numbers, velocities: Numbers, is_open: Numbers, *, epochs: int) -> float:
        """Learn from (n, 10), (n, 3) and (n,) numbers; return the last loss."""
        inputs = torch.tensor(observed, dtype=torch.float32)
        wanted = torch.tensor(velocities / SPEED, dtype=torch.float32)
        opens = torch.tensor(is_open, dtype=torch.float32)
        seen = features(inputs)
        self.mean, self.deviation = seen.mean(dim=0), seen.std(dim=0) + 1e-6
        steps = epochs * (-(-len(inputs) // BATCH))
        optimizer = torch.optim.AdamW(self.parameters(), lr=1e-3)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
        loss = torch.zeros(())
        for _ in range(epochs):
            for rows in torch.randperm(len(inputs)).split(BATCH):
                made = self(inputs[rows])
                loss = nn.functional.smooth_l1_loss(made[:, :3], wanted[rows])
                loss = loss + 0.2 * nn.functional.binary_cross_entropy_with_logits(made[:, 3], opens[rows])
                optimizer.zero_grad()
                loss.backward()
                optimizer.step()
                schedule.step()
        return float(loss.detach())

    def pilot(self, observation: Numbers) -> tuple[Numbers, bool]:
        """Drive: a `cell.Pilot`."""
        with torch.no_grad():
            made = self(torch.tensor(observation[np.newaxis], dtype=torch.float32))[0].numpy()
        return SPEED * made[:3].astype(np.float64), bool(made[3] > 0)


def features(observed: torch.Tensor) -> torch.Tensor:
    """Return (n, 9) from (n, 10): cube and mark from the tip, heights of tip and cube, finger."""
    tip, cube, mark, finger = observed[:, :3], observed[:, 3:6], observed[:, 6:9], observed[:, 9:]
    return torch.cat((cube - tip, mark - tip, tip[:, 2:], cube[:, 2:], 10 * finger), dim=1)


def load(folder: Path) -> tuple[Numbers, Numbers, Numbers]:
    """Return observations (n, 10), velocities (n, 3) and openings (n,) of all episodes of ``simx export --npz``."""
    episodes = [np.load(file) for file in sorted(folder.glob("episode-*.npz"))]
    observed = np.concatenate([each["observation"][:-1] for each in episodes])
    actions = np.concatenate([each["action"] for each in episodes])
    return observed, actions[:, :3], actions[:, 6]
