"""The certified reference of smooth systems: 40 digits, closed forms, conditioning, refusals."""

import re
from dataclasses import replace
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from plumbob.analytic.numerics.linear_flow import Response
from plumbob.analytic.numerics.smooth import certified_motion
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError
from plumbob.tests.numerics.double_pendulum import double_pendulum
from plumbob.tests.support.extrapolation import recorded

CASES = recorded(Path(__file__).with_name("recorded_motions.json"))


def stacked(values):
    """All observables, shape (numbers, n)."""
    return np.stack(list(values.values()))


def errors(name, system):
    """Error beside the recorded motion, and the uncertainty stated, shape (4, n) each."""
    motion = CertifiedMotion(system)
    times = np.array(CASES[name].times)
    states = [[mp.mpf(x) for x in row] for row in CASES[name].states]
    seen = stacked(motion.observe(times)).T
    off = [
        [float(mp.mpf(x) - y) for x, y in zip(*rows, strict=True)]
        for rows in zip(seen, states, strict=True)
    ]
    return np.abs(off).T, stacked(motion.uncertainty(times))


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("name", CASES)
def test_40_digits(name):
    with mp.workdps(45):
        error, stated = errors(name, double_pendulum(CASES[name].constants, CASES[name].start))
    assert (error <= stated).all()
    # Not excessive: rounded inputs alone move the motion by what is stated, a few times as much as
    # the two integrations, whose roundings are few.
    assert (stated.max(axis=1) <= 300 * error.max(axis=1) + 1e-13).all()


@pytest.mark.long
@pytest.mark.parametrize("name", ["large", "unequal"])
def test_condition_is_the_response_to_changed_inputs(name, monkeypatch):
    # Difference quotients of every input, summed; the condition, which is the uncertainty by inputs
    # rounded by all of them, has the rounding of the time and of the result beside them, and the
    # state's at its largest in place of that at the start.
    constants = CASES[name].constants
    start = CASES[name].start
    system = double_pendulum(constants, start)
    times = np.array([0.3, 1.9])
    change = 1e-7
    motion = CertifiedMotion(system)
    seen = stacked(motion.observe(times))
    size = np.abs(stacked(motion.observe(np.linspace(0.0, 2.0, 2001)))).max(axis=1)
    total = np.abs(seen) + np.abs(times * system.slope(times, seen))
    for key, value in system.parameters.items():
        near = replace(system, parameters={**system.parameters, key: value * (1 + change)})
        total += np.abs(stacked(CertifiedMotion(near).observe(times)) - seen) / change
    for moved in np.diag(size * change):
        at = system.start + moved
        near = replace(system, position=tuple(at[:2]), rate=tuple(at[2:]))
        total += np.abs(stacked(CertifiedMotion(near).observe(times)) - seen) / change
    monkeypatch.setattr(certified_motion, "ULP", 1.0)
    monkeypatch.setattr(certified_motion, "CERTIFIED_UNCERTAINTY", np.inf)
    ratio = stacked(CertifiedMotion(system).uncertainty(times)) / total
    assert (np.abs(ratio[:, -1] - 1.0) < 0.05).all()
    assert (ratio > 0.7).all()  # at earlier times the state has been smaller
    assert (ratio < 1.05).all()


@pytest.mark.parametrize("faulty", ["gauss_collocation", "order_8"])
def test_a_fault_in_either_integration_shows(faulty, monkeypatch):
    system = double_pendulum()
    times = np.array([0.5, 2.0])
    right = CertifiedMotion(system)
    small = stacked(right.uncertainty(times))
    exact = stacked(right.observe(times))
    good = getattr(certified_motion, faulty)

    def wrong(*about):
        found = good(*about)
        return replace(found, weights=np.array(found.weights) * (1 + 1e-11))

    monkeypatch.setattr(certified_motion, faulty, wrong)
    motion = CertifiedMotion(system)
    apart = stacked(motion.uncertainty(times))
    assert (apart > 100 * small).all()
    assert (np.abs(stacked(motion.observe(times)) - exact) <= 1.01 * apart + 1e-13).all()


def test_a_fault_between_the_steps_shows(monkeypatch):
    """Of the first method's polynomials, which are right at both ends of a step."""
    system = double_pendulum()
    times = np.linspace(0.01, 2.0, 100)
    exact = stacked(CertifiedMotion(system).observe(times))
    good = Response.at

    def wrong(response, times):
        step = response.orbit.locate(times)
        edges = response.orbit.breakpoints
        part = (times - edges[step]) / np.diff(edges)[step]
        return good(response, times) + 1e-9 * (part * (1.0 - part))[:, None]

    monkeypatch.setattr(Response, "at", wrong)
    motion = CertifiedMotion(system)
    off = np.abs(stacked(motion.observe(times)) - exact)
    assert off.max() > 2e-10
    # the second method's states are a 24th of a step apart
    assert (off <= 1.01 * stacked(motion.uncertainty(times))).all()


@pytest.mark.long
def test_chaos_beyond_double_precision_is_refused():
    motion = CertifiedMotion(double_pendulum())
    with pytest.raises(
        ParameterError, match=r"times = 60.0: must be at most 2\d\.\d+ s: double"
    ) as why:
        motion.observe(np.array([0.0, 60.0]))
    assert "\n" not in str(why.value)
    until = float(re.findall(r"[\d.]+", str(why.value))[1])
    times = np.linspace(0.0, until - 0.1, 2001)
    seen, stated = (stacked(ask(times))[:2] for ask in (motion.observe, motion.uncertainty))
    assert 3e-4 < stated.max() / np.abs(seen).max() < 1e-3
    with pytest.raises(ParameterError):
        motion.uncertainty(np.array([1000.0]))


def test_what_was_stopped_goes_on_to_the_same_digits():
    def stop(reached):
        if reached > 0.5:
            raise TimeoutError

    stopped = CertifiedMotion(double_pendulum())
    with pytest.raises(TimeoutError):
        stopped.certify(8.0, stop)
    times = np.linspace(0.0, 8.0, 9)
    whole = CertifiedMotion(double_pendulum())
    assert (stacked(stopped.observe(times)) == stacked(whole.observe(times))).all()
    assert (stacked(stopped.uncertainty(times)) == stacked(whole.uncertainty(times))).all()


def test_a_collapse_is_refused_where_it_is():
    """A fall to a centre from rest at 1 m, k = 1 m^3/s^2: it ends after pi/sqrt(8) s."""
    motion = CertifiedMotion(
        SmoothSystem(
            ("x",),
            ("v",),
            lambda p, q: ((1.0,),),
            lambda p, t, q, v: (-p.k / q[0] ** 2,),
            {"k": 1.0},
            (1.0,),
            (0.0,),
        )
    )
    assert motion.observe(np.array([1.0]))["x"][0] == pytest.approx(0.3506816, rel=1e-6)
    with pytest.raises(ParameterError) as why:
        motion.observe(np.array([2.0]))
    ends = float(re.findall(r"[\d.]+", str(why.value))[1])
    assert ends == pytest.approx(np.pi / np.sqrt(8.0), rel=1e-3)


@pytest.mark.parametrize("mass", [0.0, np.nan])
def test_a_mass_matrix_that_is_not_positive_is_refused(mass):
    with pytest.raises(
        ParameterError, match=r"mass matrix = .* must be symmetric and positive"
    ):
        double_pendulum((1.0, mass, 1.0, 1.0, 9.81))
