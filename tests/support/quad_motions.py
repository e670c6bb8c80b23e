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
    """Values of each scene's observables, at times early and late."""
    times = np.append(np.linspace(0.0, 2.0, 40), [1e3, 1e6])
    motions = {name: case_of(scene(name)).reference.observe(times) for name in SCENES}
    return {
        name: {of: values.tolist() for of, values in motion.items()}
        for name, motion in motions.items()
    }
