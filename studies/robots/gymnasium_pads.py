"""How do thousands of sensors train a policy? A vector environment of Gymnasium, a twin a pad, all in one call.

Each pad is to be loaded to a force of its own, seen through the converter's codes alone: the observation is the change
of each coil's code since rest over its range, and the goal; an action changes F_x and F_z by up to a twentieth of their
range in a step of a millisecond; the reward is minus the distance to the goal over the ranges. Noise is that of the
converter (sigma_L; a code is C L^-1/2). Needs gymnasium and the folder of ``sits-mech export DIR --to twin``.
Run ``PYTHONPATH=FOLDER python studies/robots/gymnasium_pads.py FOLDER``.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from twin import Twin

STEP, LENGTH, SHARE = 1e-3, 200, 0.05  # [s]; steps of an episode; of the range, what an action moves


class Pads(VectorEnv):
    """Pads to be loaded to forces of their own.

    Parameters
    ----------
    folder : Path
        Of the twin.
    num_envs : int
        Pads.
    """

    metadata = {"autoreset_mode": AutoresetMode.DISABLED}

    def __init__(self, folder: Path, num_envs: int = 4096) -> None:
        self.twin, self.num_envs = Twin.load(folder / "sensor.npz"), num_envs
        numbers = self.twin.numbers
        self.low, self.high, self.columns = (numbers[f"wrench_{name}"] for name in ("low", "high", "columns"))
        coils, forces = len(self.twin.coils), len(self.columns)
        self.single_observation_space = Box(-np.inf, np.inf, (coils + forces,), np.float32)
        self.single_action_space = Box(-1.0, 1.0, (forces,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.rest = self.twin.read(np.zeros((1, 6))).codes
        self.sigma = 0.5 * numbers["sigma_L"] * (self.rest + numbers["below"])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Return the first observations of pads without load, each with a new goal."""
        super().reset(seed=seed)
        self.count, self.state = 0, self.twin.start(self.num_envs)
        self.wrench = np.zeros((self.num_envs, 6))
        self.goal = self.np_random.uniform(self.low, self.high, (self.num_envs, len(self.low)))
        return self._seen(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Return observations, rewards, ends and truncations of all pads."""
        load = self.wrench[:, self.columns] + SHARE * (self.high - self.low) * np.clip(actions, -1.0, 1.0)
        self.wrench[:, self.columns] = np.clip(load, self.low, self.high)
        self.count += 1
        seen = self._seen()
        off = (self.wrench[:, self.columns] - self.goal) / (self.high - self.low)
        done = np.zeros(self.num_envs, dtype=bool)
        return seen, -np.linalg.norm(off, axis=1), done, done | (self.count >= LENGTH), {"flags": self.flags}

    def _seen(self) -> Any:
        """Return codes with noise, less those at rest, over their range, and the goals."""
        self.state, shown = self.twin.step(self.state, self.wrench, STEP)
        self.flags = shown.flags
        noise = self.sigma * self.np_random.standard_normal(shown.codes.shape)
        codes = (np.rint(shown.codes + noise) - self.rest) / self.twin.numbers["scale_codes"]
        goal = (self.goal - self.low) / (self.high - self.low)
        return np.hstack([codes, goal]).astype(np.float32)


def main(folder: Path) -> None:
    """Press all pads towards their goals by what the codes say, and tell how fast that is."""
    pads = Pads(folder)
    seen, _ = pads.reset(seed=1)
    began, total, coils = time.perf_counter(), 0.0, len(pads.twin.coils)
    for _ in range(LENGTH):
        codes = pads.rest + np.rint(seen[:, :coils] * pads.twin.numbers["scale_codes"]).astype(int)
        force = np.nan_to_num(pads.twin.estimate_codes(codes).wrench[:, pads.columns])
        goal = pads.low + seen[:, coils:] * (pads.high - pads.low)
        seen, reward, *_ = pads.step((goal - force) / (SHARE * (pads.high - pads.low)))
        total = float(reward.mean())
    took = time.perf_counter() - began
    print(f"{pads.num_envs} pads, {LENGTH} steps in {took:.2f} s; mean distance at the end {-total:.1e} of the range")
    print(f"gymnasium {gymnasium.__version__}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
