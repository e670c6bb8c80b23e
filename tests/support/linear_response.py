"""Sensitivity of a rotor's motion to its coefficients, its condition, and the growth of
an error of the start."""

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors


def partials_of(rotor, t, x, v):
    """Partial derivative of the acceleration by each coefficient, keyed by the field's name."""
    phase = rotor.forcing_frequency * t + rotor.forcing_phase
    swing = rotor.forcing_amplitude * np.cos(phase)
    return {
        "sin2": np.sin(2 * x),
        "cos": np.cos(x),
        "sin": -np.sin(x),
        "damping_rate": -v,
        "forcing_amplitude": np.sin(phase),
        "forcing_frequency": t * swing,
        "forcing_phase": swing,
        "stiffness": -x,
    }


def parameter_sensitivity(rotor, theta, theta_dot, times):
    """Derivatives of (theta, theta_dot) at `times` [s], shape (n,), by each coefficient of the
    rotor, by the field's name, shape (n, 2). Raises ParameterError."""
    motion = RotorErrors(rotor, theta, theta_dot).motion
    grid = motion.grid(float(np.max(times, initial=0.0)) or 1.0)
    nodes, states, flow = motion.linearised(grid)
    partials = partials_of(rotor, nodes, *states)
    forcing = np.zeros((*flow.matrix.shape[:3], len(partials)))
    forcing[:, :, 1, :] = np.stack(list(partials.values()), -1).reshape(*forcing.shape[:2], -1)
    values = flow.respond(np.zeros((2, len(partials))), forcing).at(times)
    return {name: values[:, :, column] for column, name in enumerate(partials)}


def condition(rotor, theta, theta_dot, times):
    """Condition of theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,): their change for a
    relative change of one in every input, summed in magnitude; times the machine epsilon, the
    effect of inputs rounded to double. Raises ParameterError."""
    motion = RotorErrors(rotor, theta, theta_dot).motion
    by_number = parameter_sensitivity(rotor, theta, theta_dot, times)
    start = np.abs(motion.tangents(times)) @ np.abs([theta, theta_dot])
    total = start + sum(abs(getattr(rotor, n)) * np.abs(rows) for n, rows in by_number.items())
    x, v = motion.state(times)
    return {
        "theta": total[:, 0] + np.abs(times * v),
        "theta_dot": total[:, 1] + np.abs(times * rotor.acceleration(times, x, v)),
    }
