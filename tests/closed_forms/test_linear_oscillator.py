"""The linear oscillator's closed form against 60 digits, with separate and with double roots."""

import math
from dataclasses import replace
from types import MappingProxyType

import mpmath as mp
import numpy as np
import pytest

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import linear_motion
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion

DIGITS = 60
TIMES = np.concatenate([np.linspace(0.0, 50.0, 26), 10.0 ** np.linspace(-9.0, 0.9, 20)])
# Each formula is a product of a few factors with errors of half an ulp (1.1e-16 relative): 1e-15 of
# the largest part covers ten roundings.
ROUNDING = 1e-15


def linear(stiffness, damping_rate=0.0, *forcing):
    """The rotor with a forcing's amplitude, frequency and phase."""
    return DrivenRotor(0.0, 0.0, 0.0, damping_rate, *(*forcing, 0.0, 0.0, 0.0)[:3], stiffness)


OSCILLATORS = MappingProxyType(
    {
        "undamped": linear(9.8),
        "underdamped": linear(9.8, 0.08),
        "critical": linear(9.0, 6.0),
        "overdamped": linear(9.8, 50.0),
        "heavily overdamped": linear(9.8, 1e5),
        "forced": linear(9.8, 0.08, 0.1, 3.0, 0.3),
        "forced backwards": linear(9.8, 0.1, 1.0, -3.0, 0.4),
        "damped at 1e4 /s": linear(9.8, 1e4),
        "a stiff spring": linear(1e6),
        "a stiff servo": linear(1e6, 2e3, 1e6, 2.0),
        "forced fast": linear(9.8, 0.1, 1.0, 1e4),
        "forced slowly, stiff": linear(1e8, 2e4, 1.0, 3.0),
        "forced, critical": linear(9.0, 6.0, 0.7, 1e-9),
        "resonance": linear(9.0, 0.0, 0.5, 3.0),
        "near resonance": linear(9.8, 0.0, 0.5, math.sqrt(9.8)),
        "nearly undamped resonance": linear(9.0, 1e-9, 0.5, 3.0),
        "inverted": linear(-0.25, 0.1, 1.0, 3.0, 0.4),
        "free": linear(0.0, 0.0, 1.0, 3.0, 0.4),
        "free with drag": linear(0.0, 2.0, 1.0, 1e-8, 0.4),
        **{
            f"critical damping times {1 + gap!r}": linear(9.0, 6.0 * (1 + gap), 0.4, 2.0)
            for size in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15)
            for gap in (size, -size)
        },
    }
)


def parts(oscillator, time):
    """What theta and theta_dot are per unit of the initial angle and of the initial rate, and by a
    complex forcing, as columns, with 60 digits: by the exponential of the matrix of the angle, the
    rate, and the cosine and sine of the forcing."""
    k, xi, frequency = (
        mp.mpf(value)
        for value in (
            oscillator.stiffness,
            oscillator.damping_rate,
            oscillator.forcing_frequency,
        )
    )
    push = mp.mpf(oscillator.forcing_amplitude)
    rates = [[0, 1, 0, 0], [-k, -xi, 0, push], [0, 0, 0, -frequency], [0, 0, frequency, 0]]
    flow = mp.expm(mp.matrix(rates) * mp.mpf(float(time)))
    wave = mp.expj(mp.mpf(oscillator.forcing_phase))
    forced = ((flow[i, 3] + 1j * flow[i, 2]) * wave for i in (0, 1))
    return mp.matrix([[flow[i, 0], flow[i, 1], part] for i, part in enumerate(forced)])


def worst(oscillator, times, *starts):
    """Largest error of motions from these angles and rates, over the largest of the parts that
    superpose, of theta or theta_dot."""
    with mp.workdps(DIGITS):
        per_unit = [parts(oscillator, t) for t in times]
        return max(_worst(oscillator, times, start, per_unit) for start in starts)


def _worst(oscillator, times, start, units):
    truths = [unit * mp.diag([*start, 1]) for unit in units]
    return float(
        max(
            max(
                abs(mp.mpf(float(a)) - mp.re(b[i, 0] + b[i, 1]) - mp.im(b[i, 2]))
                for a, b in zip(values, truths, strict=True)
            )
            / (max(abs(b[i, column]) for b in truths for column in range(3)) or 1)
            for i, values in enumerate(linear_motion(oscillator, *start, times))
        )
    )


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("name", OSCILLATORS)
def test_the_closed_form_is_accurate_to_double_precision(name):
    moving = (0.7, -0.4)
    at_rest = (0.0, 0.0)
    assert worst(OSCILLATORS[name], TIMES, moving, at_rest) < ROUNDING


@pytest.mark.parametrize(
    ("name", "field", "off"),
    [
        ("underdamped", "damping_rate", 0.08e-9),
        ("forced", "forcing_phase", 1e-9),
        ("resonance", "stiffness", 9e-9),
        ("critical", "stiffness", 9e-9),
    ],
)
def test_a_coefficient_error_of_1e_9_is_detected(name, field, off):
    right = OSCILLATORS[name]
    wrong = replace(right, **{field: getattr(right, field) + off})
    x, y = (linear_motion(oscillator, 0.7, -0.4, TIMES)[0] for oscillator in (wrong, right))
    assert np.abs(x - y).max() > 1e4 * ROUNDING * np.abs(y).max()


@pytest.mark.parametrize("name", ["underdamped", "forced", "resonance", "overdamped"])
def test_two_integrations_agree_with_the_closed_form(name):
    oscillator = OSCILLATORS[name]
    times = np.linspace(0.0, 50.0, 201)
    motion = DrivenMotion(oscillator, 0.7, -0.4)
    assert motion.closed_form is not None
    allowed = motion.uncertainty(times)["theta"] + motion.certified.uncertainty(times)["theta"]
    gaps = np.abs(motion.observe(times)["theta"] - motion.certified.observe(times)["theta"])
    assert (gaps <= allowed).all()
    assert allowed.max() < 1e-11


def test_what_decays_leaves_the_forcing_and_no_warning():
    stiff = linear(1e6, 2e3, 1e6, 2.0)
    theta, _ = linear_motion(stiff, -0.004, 2.0, np.linspace(0.0, 3.0, 4001))
    assert theta[-1] == pytest.approx(math.sin(6.0 - 0.004), rel=1e-4)
