"""The driven rotor: two methods against each other and 32 digits, energy, sensitivity."""

from __future__ import annotations

import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings

from plumbob.analytic.numerics.rotor import gauss_collocation, taylor_series
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.tests.support.pendulum_cases import CASES, Case, cases, endpoint, motion

# Theta and theta_dot after 50 s with 32 digits: Taylor series of order 40, 800 steps (`_advance`).
AFTER_50 = {
    "damped-small": ("-0.01873959821573361604727388", "-0.04417352722322775847233064"),
    "damped-large": ("0.2381722724319633036834378", "0.2356796102891072994460339"),
    "damped-rotating": ("25.12485033470987732040486", "-0.06820795669690090149480561"),
    "forced-small": ("-0.09364563811642821276648874", "0.1488751741747061011013264"),
    "forced-large": ("-1.092695228019585363144847", "3.107280871581082166706706"),
    "forced-chaotic": ("-24.36930513095299734407784", "1.618462898350613560382635"),
}


def _advance(
    rotor: DrivenRotor, t: mp.mpf, x: mp.mpf, v: mp.mpf, h: mp.mpf
) -> tuple[mp.mpf, mp.mpf]:
    """One Taylor step of order 40 in mpmath numbers: slow, plain, of simple pendulums only."""
    xi, frequency = mp.mpf(rotor.damping_rate), mp.mpf(rotor.forcing_frequency)
    phase = frequency * t + mp.mpf(rotor.forcing_phase)
    cycle = [mp.sin(phase), mp.cos(phase), -mp.sin(phase), -mp.cos(phase)]
    sine, cosine, xs, vs = [mp.sin(x)], [mp.cos(x)], [x, v], [v]
    for n in range(39):
        if n:
            s = mp.fdot(vs, reversed(cosine)) / n
            cosine.append(-mp.fdot(vs, reversed(sine)) / n)
            sine.append(s)
        push = rotor.forcing_amplitude * cycle[n % 4] * frequency**n / mp.factorial(n)
        vs.append((push - mp.mpf(rotor.sin) * sine[n] - xi * vs[n]) / (n + 1))
        xs.append(vs[-1] / (n + 2))
    slopes = [n * term for n, term in enumerate(xs)][1:]
    return mp.polyval(xs, h, asc=True), mp.polyval(slopes, h, asc=True)


def test_the_table_of_32_digits_follows_from_the_equation() -> None:
    case = CASES["damped-large"]
    with mp.workdps(32):
        h, x, v = mp.mpf(50) / 800, mp.mpf(case.theta), mp.mpf(case.theta_dot)
        for n in range(64):
            x, v = _advance(case.rotor, n * h, x, v, h)
        orbit = taylor_series.integrate(case.rotor, case.theta, case.theta_dot, 4.0)
        # 4 s are 1.3 periods of a swing that is not sensitive: a few roundings of 2 rad, 5 rad/s
        assert abs(x - mp.mpf(float(orbit.theta[-1]))) < 1e-15
        assert abs(v - mp.mpf(float(orbit.theta_dot[-1]))) < 2e-15


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("name", AFTER_50)
def test_both_methods_reach_the_32_digits(name: str) -> None:
    case = CASES[name]
    second = gauss_collocation.integrate(case.rotor, case.theta, case.theta_dot, 50.0)
    spread = {q: float(u[0]) for q, u in motion(case).uncertainty(np.array([50.0])).items()}
    for found in (endpoint(case), (second.theta[-1], second.theta_dot[-1])):
        for value, digits, unit in zip(found, AFTER_50[name], ("theta", "theta_dot"), strict=True):
            error = abs(float(mp.mpf(float(value)) - mp.mpf(digits)))
            # its own arithmetic stays below the effect of rounding the inputs
            assert error <= spread[unit]
            # and, with the growth along the chaotic orbit (430), below the required 1e-13
            assert error <= 1e-13


def _elliptic(case: Case, time: mp.mpf) -> mp.mpf:
    """The undamped simple pendulum by Jacobi functions, from any start (Lawden 1989, ch. 5)."""
    g, x, v = mp.mpf(case.rotor.sin), mp.mpf(case.theta), mp.mpf(case.theta_dot)
    m = mp.sin(x / 2) ** 2 + v**2 / (4 * g)  # above one: rotation
    if m < 1:
        if v:
            raise NotImplementedError
        begin = mp.ellipk(m) * mp.sign(x)
        sn = mp.ellipfun("sn", mp.sqrt(g) * time + begin, m=m)
        return 2 * mp.asin(mp.sqrt(m) * sn)
    rate, turn = mp.sqrt(g * m), mp.ellipk(1 / m)
    u = mp.ellipf(x / 2, 1 / m) + rate * time
    whole = mp.nint(u / (2 * turn))
    sn = mp.ellipfun("sn", u - whole * 2 * turn, m=1 / m)
    return 2 * (mp.asin(sn) + whole * mp.pi)


@pytest.mark.parametrize("name", ["free-small", "free-large", "rotating-slow", "rotating-fast"])
def test_undamped_swings_and_turns_are_those_of_jacobi(name: str) -> None:
    case = CASES[name]
    times = np.linspace(0.0, 50.0, 41)
    exact = motion(case)
    found, allowed = exact.observe(times)["theta"], exact.uncertainty(times)["theta"]
    with mp.workdps(40):
        errors = [
            abs(float(mp.mpf(float(x)) - _elliptic(case, mp.mpf(float(t)))))
            for t, x in zip(times, found, strict=True)
        ]
    assert np.all(errors <= allowed + 1e-16)
    assert max(errors) < 3e-13


def test_the_cone_has_its_check_values() -> None:
    case = CASES["cone"]
    # physics.md gives 17 digits; 37 rad/s for half a second is 20 rad, half an ulp of which is
    # 1.8e-15, and the motion doubles the roundings of the three coefficients
    assert endpoint(case) == pytest.approx([19.655093168749575, 45.196918078698202], rel=1e-15)


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("name", CASES)
def test_the_two_methods_agree_to_3e_12_over_50_seconds(name: str) -> None:
    case = replace(CASES[name], duration=50.0 if name != "cone" else 5.0)
    _, gaps = motion(case).disagreement
    assert gaps["theta"][-1] <= 3e-12
    assert gaps["theta_dot"][-1] <= 3e-12


@settings(max_examples=25)
@given(case=cases())
def test_the_two_methods_agree_on_any_rotor(case: Case) -> None:
    exact = motion(case)
    _, gaps = exact.disagreement
    floor = np.finfo(float).eps * exact.condition["theta"].max()
    # each method has a few hundred roundings of random sign, each of the size of an input's
    assert gaps["theta"][-1] <= 30 * floor + 1e-15


@settings(max_examples=25)
@given(case=cases(conservative=True))
def test_energy_is_constant_without_damping_and_forcing(case: Case) -> None:
    exact = motion(case)
    seen = exact.observe(np.linspace(0.0, case.duration, 101))
    energy = case.rotor.energy(seen["theta"], seen["theta_dot"])
    scale = case.rotor.energy(0.0, np.abs(seen["theta_dot"]).max()) + 30.0  # of its terms
    assert np.abs(energy - energy[0]).max() <= 1e-14 * abs(scale)


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
def test_a_small_mistake_exceeds_the_error_bar(change: dict[str, float], name: str) -> None:
    case = CASES[name]
    times = np.linspace(0.0, 50.0, 501)
    right, wrong = motion(case), motion(replace(case, rotor=replace(case.rotor, **change)))
    gap = np.abs(wrong.observe(times)["theta"] - right.observe(times)["theta"])
    assert (gap / right.uncertainty(times)["theta"])[1:].max() > 1e5


def test_a_term_left_out_of_one_method_shows_as_disagreement() -> None:
    case = CASES["forced-large"]
    other = replace(case.rotor, forcing_phase=1e-9)
    first = taylor_series.integrate(case.rotor, case.theta, case.theta_dot, 50.0)
    second = gauss_collocation.integrate(other, case.theta, case.theta_dot, 50.0)
    assert np.abs(first.at(second.times)[0] - second.theta).max() > 1e-10


def test_rest_at_the_bottom_stays() -> None:
    still = Case(DrivenRotor(sin=9.8, damping_rate=0.1), 0.0, 0.0, 10.0)
    seen = motion(still).observe(np.linspace(0.0, 10.0, 11))
    assert not seen["theta"].any()
    assert not seen["theta_dot"].any()


