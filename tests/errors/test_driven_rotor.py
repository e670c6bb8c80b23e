"""The driven rotor: two methods against each other and 32 digits."""

from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

from plumbob.tests.support.pendulum_cases import CASES, endpoint, motion

# Theta and theta_dot after 50 s, by a Taylor series of order 40 in 32 digits. So does
# mpmath.odefun(lambda t, y: [y[1], push(t) - sin * mp.sin(y[0]) - damping_rate * y[1]], 0, start)
# at 50 with mp.dps = 36, in 40 s.
AFTER_50 = {
    "damped-small": ("-0.01873959821573361604727388", "-0.04417352722322775847233064"),
    "damped-large": ("0.2381722724319633036834378", "0.2356796102891072994460339"),
    "damped-rotating": ("25.12485033470987732040486", "-0.06820795669690090149480561"),
    "forced-small": ("-0.09364563811642821276648874", "0.1488751741747061011013264"),
    "forced-large": ("-1.092695228019585363144847", "3.107280871581082166706706"),
    "forced-chaotic": ("-24.36930513095299734407784", "1.618462898350613560382635"),
}


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("name", AFTER_50)
def test_the_motion_reaches_the_32_digits(name):
    at = np.array([50.0])
    exact = motion(CASES[name])
    values = exact.observe(at)
    spread = exact.uncertainty(at)
    for digits, observable in zip(AFTER_50[name], ("theta", "theta_dot"), strict=True):
        error = abs(float(mp.mpf(float(values[observable][0])) - mp.mpf(digits)))
        # its own arithmetic stays below the effect of rounding the inputs
        assert error <= spread[observable][0]
        # and, with the growth along the chaotic orbit (430), below 1e-12
        assert error <= 1e-12


def test_the_cone_has_its_check_values():
    case = CASES["cone"]
    # physics.md gives 17 digits; 37 rad/s for half a second is 20 rad, half an ulp of which is
    # 1.8e-15, and the motion doubles the roundings of the three coefficients
    assert endpoint(case) == pytest.approx([19.655093168749575, 45.196918078698202], rel=2e-15)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"damping_rate": 0.2 * (1 + 1e-6)}, "damped-rotating"),
        ({"sin": 9.8 * (1 + 1e-6)}, "free-large"),
        ({"sin": 9.8 / (1 + 1e-6)}, "forced-large"),  # a length error of 1e-6
        ({"forcing_phase": 2.8 * 0.5 * 1e-5}, "forced-large"),  # half a step of 1e-5 s
    ],
)
def test_a_small_mistake_exceeds_the_error_bar(change, name):
    case = CASES[name]
    times = np.linspace(0.0, 50.0, 501)
    right = motion(case)
    wrong = motion(replace(case, rotor=replace(case.rotor, **change)))
    gap = np.abs(wrong.observe(times)["theta"] - right.observe(times)["theta"])
    assert (gap / right.uncertainty(times)["theta"])[1:].max() > 1e5
