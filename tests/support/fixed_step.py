"""Fixed-step schemes on the driven rotor in plain floats, to compare the error theory with."""

from math import cos, sin

import numpy as np

from plumbob.analytic.schemes import LEAPFROG, RK4


def run(rotor, theta, theta_dot, step, steps, scheme):
    """Theta and theta_dot at times 0, step ... steps * step."""
    h = step
    xi = rotor.damping_rate
    base = scheme.integrator
    held = {"start": 0.0, "midpoint": 0.5}.get(scheme.control)

    def pull(x):
        constant = rotor.sin2 * sin(2 * x) + rotor.cos * cos(x) - rotor.sin * sin(x)
        return constant - rotor.stiffness * x

    def push(t, part):
        time = t + h * (part if held is None else held)
        return rotor.forcing_amplitude * sin(
            rotor.forcing_frequency * time + rotor.forcing_phase
        )

    x, v = theta, theta_dot
    motion = [(x, v)]
    for n in range(steps):
        t = n * h
        if base == RK4:
            k, m, end, turn = 0.0, 0.0, 0.0, 0.0
            for part, weight in ((0.0, 1), (0.5, 2), (0.5, 2), (1.0, 1)):
                y = x + part * h * k
                w = v + part * h * m
                k = w
                m = pull(y) - xi * w + push(t, part)
                end = end + weight * k
                turn = turn + weight * m
            x = x + h / 6 * end
            v = v + h / 6 * turn
        elif base == LEAPFROG:
            v += h / 2 * (pull(x) - xi * v + push(t, 0.0))
            x += h * v
            v = (v + h / 2 * (pull(x) + push(t, 1.0))) / (1 + xi * h / 2)
        elif scheme.position_first:
            x += h * v
            v += h * (pull(x) - xi * v + push(t, 0.0))
        elif scheme.implicit_damping:
            v = (v + h * (pull(x) + push(t, 0.0))) / (1 + h * xi)
            x += h * v
        else:
            v += h * (pull(x) - xi * v + push(t, 0.0))
            x += h * v
        motion.append((x, v))
    return np.array(motion).T[0], np.array(motion).T[1]


def mean_acceleration(motion, edges):
    """Mean of the slider's acceleration in the body over each step between `edges` [s], shape
    (n + 1,), in a `motion` along a line: shape (n,) [m/s^2], as engines impose it."""
    return np.asarray(np.diff(motion.relative_velocity(edges)) / np.diff(edges))
