"""Linear policies of Gymnasium's tasks, found by random search at the step of their files.

    python -m plumbob.tests.validation.trained_policies [TASK ...]

Writes the weights of each task into tests/validation/trained/TASK.txt: a row for each action, the
factors of the observation and a constant. Each iteration tries random changes of the weights to
both sides, on episodes with the same start, and moves along the better ones (Mania, Guy and Recht
2018, Simple random search of static linear policies). The seed is fixed; a task takes a minute.
"""

import importlib
import sys
import warnings
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "trained"
SEED = 7
# Task: periods in an episode, iterations, directions in each, the best of them, size of the changes
# and of the moves
TASKS = {
    "HalfCheetah-v5": (100, 200, 16, 8, 0.03, 0.03),
    "Hopper-v5": (250, 80, 8, 4, 0.03, 0.03),
}


def trained(task):
    """The weights of a task, shape (actions, observations + 1), and the mean returns on the way."""
    count, iterations, directions, best, size, move = TASKS[task]
    environment = importlib.import_module("gymnasium").make(task)
    observations = environment.observation_space.shape[0]
    actions = environment.action_space.shape[0]
    draw = np.random.default_rng(SEED)
    seen = Statistics(observations)
    weights = np.zeros((actions, observations))
    returns = []
    for iteration in range(iterations):
        changes = draw.standard_normal((directions, actions, observations))
        pairs = np.array(
            [
                [
                    episode(environment, weights + side * size * change, seen, count, iteration)
                    for side in (1.0, -1.0)
                ]
                for change in changes
            ]
        )
        order = np.argsort(-pairs.max(axis=1))[:best]
        gains = pairs[order, 0] - pairs[order, 1]
        scale = max(pairs[order].std(), 1e-6)
        weights += move / (best * scale) * np.tensordot(gains, changes[order], 1)
        returns.append(pairs.mean())
    factors = weights / seen.deviation
    return np.column_stack([factors, -factors @ seen.mean]), returns


class Statistics:
    """Mean and standard deviation of all observations."""

    def __init__(self, size):
        self.count, self.mean, self.squares = 0, np.zeros(size), np.zeros(size)

    def add(self, observation):
        self.count += 1
        change = observation - self.mean
        self.mean += change / self.count
        self.squares += change * (observation - self.mean)

    @property
    def deviation(self):
        found = np.sqrt(self.squares / max(1, self.count - 1))
        return np.where(found > 1e-6, found, 1.0)


def episode(environment, weights, seen, count, seed):
    """The return of an episode under linear weights of normalised observations."""
    observation, _ = environment.reset(seed=seed)
    mean, deviation = seen.mean.copy(), seen.deviation
    total = 0.0
    for _ in range(count):
        seen.add(observation)
        action = np.clip(weights @ ((observation - mean) / deviation), -1.0, 1.0)
        observation, reward, ended, *_ = environment.step(action)
        total += reward
        if ended:
            break
    return total


def main(names):
    """Search weights for the named tasks, or for all, and write them."""
    FOLDER.mkdir(exist_ok=True)
    for name in names or TASKS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            weights, returns = trained(name)
        np.savetxt(FOLDER / f"{name}.txt", weights, fmt="%.6g")
        print(name, *(f"{value:.1f}" for value in returns[:: max(1, len(returns) // 20)]))


if __name__ == "__main__":
    main(sys.argv[1:])
