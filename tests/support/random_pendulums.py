"""Cone pendulums drawn at random, reproducibly, with the same number in each regime."""

import math
from dataclasses import replace

import numpy as np

from plumbob.analytic.systems.cone_pendulum import ConePendulum, HungBody, solid_cone

REGIMES = (
    "rotation forward",
    "rotation backward",
    "only well",
    "deeper well",
    "shallower well",
    "both wells",
    "small swing",
    "just above the highest barrier",
    "just below the highest barrier",
    "just above the lower barrier",
    "just below the lower barrier",
)


def pendulums(count, seed=2015):
    """Draw `count` pendulums, each with the name of its regime, in turn."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        regime = REGIMES[i % len(REGIMES)]
        while (drawn := _started(rng, _platform(rng), regime)) is None:
            pass
        yield regime, drawn


def _platform(rng):
    """A body at rest on a platform: half of them cones, apex angles to 170 degrees, where
    I_x < I_z; half with different moments; at 0 to 1000 rad/s."""
    if rng.random() < 0.5:
        apex = math.radians(rng.uniform(5.0, 170.0))
        body = solid_cone(rng.uniform(500.0, 9000.0), rng.uniform(0.05, 2.0), apex)
    else:
        squares = rng.uniform(0.01, 1.0, 3)  # second moments along the axes
        mass = rng.uniform(0.1, 50.0)
        arm = rng.uniform(0.02, 1.0)
        moments = mass * (squares.sum() - squares)
        least = mass * arm**2
        body = HungBody(mass, arm, moments[0] + least, moments[1] + least, moments[2])
    rate = float(rng.choice([0.0, 1000.0, 10.0 ** rng.uniform(-1.0, 3.0)], p=[0.05, 0.05, 0.9]))
    pivot = float(rng.choice([0.0, rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-6.0, 0.0)]))
    gravity = float(rng.choice([0.0, 1.62, 9.8], p=[0.1, 0.2, 0.7]))
    return ConePendulum(body, rng.uniform(-1.0, 1.0), pivot, rate, gravity, 0.0, 0.0)


def _started(rng, platform, regime):
    """The pendulum started in a regime, or None where its potential has no such regime."""
    wells = sorted((e for e in platform.equilibria if e.kind == "centre"), key=_potential)
    crests = sorted((e for e in platform.equilibria if e.kind == "saddle"), key=_potential)
    if not wells or not crests:
        return None
    top = crests[-1].potential
    low = crests[0].potential
    bottom = wells[0].potential
    height = top - bottom
    theta = _within(rng, wells[0].theta, crests)
    sign = float(rng.choice([-1.0, 1.0]))
    near = 10.0 ** -rng.uniform(3.0, 12.0)
    two = len(wells) == 2 and low - wells[1].potential > 1e-3 * height
    if regime.startswith("rotation"):
        energy = top + height * 10.0 ** rng.uniform(-2.0, 2.0)
        sign = -1.0 if regime.endswith("backward") else 1.0
    elif regime == "small swing":
        well = wells[rng.integers(len(wells))]
        return replace(platform, theta=well.theta + sign * near)
    elif "highest" in regime:
        excess = near * height * (1.0 if "above" in regime else -1.0)
        try:
            return replace(platform, theta=theta, theta_dot=sign, excess=excess)
        except ValueError:
            return None
    elif regime == "only well":
        if len(wells) == 2:
            return None
        energy = bottom + height * rng.uniform(0.01, 0.99)
    elif not two or top - low < 1e-3 * height:
        return None
    elif regime == "both wells":
        energy = rng.uniform(low, top)
    else:
        well = wells[rng.integers(2)]
        well = {"deeper well": wells[0], "shallower well": wells[1]}.get(regime, well)
        theta = _within(rng, well.theta, crests)
        energy = rng.uniform(well.potential, low)
        if "lower" in regime:
            energy = low + near * height * (1.0 if "above" in regime else -1.0)
    theta += 2 * math.pi * rng.integers(-3, 4)
    here = float(platform.potential.value(theta))
    if energy <= here:
        return None
    speed = math.sqrt(2 * (energy - here) / platform.body.inertia_x)
    return replace(platform, theta=theta, theta_dot=sign * speed)


def _potential(equilibrium):
    return equilibrium.potential


def _within(rng, well, crests):
    """An angle between a well and one of the crests on its sides."""
    gaps = [math.remainder(c.theta - well, 2 * math.pi) for c in crests]
    return well + float(rng.choice(gaps)) * rng.uniform(0.0, 0.95)
