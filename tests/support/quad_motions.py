"""Motions that 34 digits are used for, by whichever arithmetic is installed."""

import numpy as np

from plumbob.models.registry import case_of, scene

SCENES = (
    "cone-pendulum/rotating-base",
    "cone-pendulum/fast-platform",
    "free-body/flip",
    "linear-pendulum/overdamped",
    "servo/joint-damped",
    "simple-pendulum/free-large",
)


def observed():
    """Values of each scene's observables, and their uncertainty, at times early and late."""
    times = np.append(np.linspace(0.0, 2.0, 40), [1e3, 1e6])
    found = {}
    for name in SCENES:
        motion = case_of(scene(name)).reference
        values, doubts = motion.observe(times), motion.uncertainty(times)
        found[name] = {of: [values[of].tolist(), doubts[of].tolist()] for of in values}
    return found
