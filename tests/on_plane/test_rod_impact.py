"""Routh's impact of a rod against 40 digits and a stiff spring; what engines make of Painleve's."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.errors.contact_models import impacts, rod_steps
from plumbob.analytic.numerics.point_impact import LAWS
from plumbob.engines.method import meant
from plumbob.engines.registry import limits_of, method, methods
from plumbob.engines.study.measurement import measure, scheme_of
from plumbob.models.registry import case_of, matching_scenes, scene
from plumbob.reports.judge.verdict import judge

ROD = case_of(scene("rod-impact/sticks")).problem
STARTS = {  # angle, height, speed, friction
    "sticks": (0.7, 0.5, 0.5, 1.0),
    "slides": (1.1, 0.5, -2.0, 0.3),
    "reverses": (0.7, 0.5, 1.0, 0.3),
    "reverses late": (0.7, 0.5, 3.0, 0.3),
    "leans forward": (2.0, 0.5, 1.0, 0.3),
    "no slip": (0.7, 0.5, 0.0, 0.2),
    "smooth": (0.7, 0.5, 1.0, 0.0),
    "jams": (1.1, 0.5, -2.0, 3.0),
    "jams at rest": (1.1, 0.0, -2.0, 3.0),
}


def rod(start, **more):
    named = dict(zip(("angle", "height", "speed", "friction"), STARTS[start], strict=True))
    return replace(ROD, **{**named, **more})


def impulses(of):
    """P and Q [N s], by the slip and the speed v as functions of P, and its work as an integral."""
    m, t, f, e = (mp.mpf(x) for x in (of.mass, of.angle, of.friction, of.restitution))
    a = 1 + 3 * mp.sin(t) ** 2
    b = -3 * mp.sin(t) * mp.cos(t)
    c = 1 + 3 * mp.cos(t) ** 2
    start = mp.mpf(of.speed)
    v = -mp.sqrt(2 * mp.mpf(of.gravity) * mp.mpf(of.height))
    held = -b / a if abs(b / a) <= f else -f * mp.sign(b)
    first = -f * mp.sign(start) if start else held
    ends = -start * m / (b + a * first) if start * (b + a * first) <= 0 else mp.inf

    def friction(p):
        return first * min(p, ends) + (held * (p - ends) if p > ends else 0)

    def off(p):
        return v + (c * p + b * friction(p)) / m

    def work(low, high):
        inside = [ends] if low < ends < high else []
        return mp.quad(off, [low, *inside, high])

    def root(of_p, low, high):
        for _ in range(140):
            middle = (low + high) / 2
            low, high = (middle, high) if of_p(middle) < 0 else (low, middle)
        return low

    far = mp.mpf(1000) * m
    compressed = root(lambda p: off(p) if p > ends or c + b * first > 0 else -1, mp.mpf(0), far)
    if of.law == "newton":
        total = root(lambda p: off(p) + e * v, compressed, far)
    elif of.law == "poisson":
        total = (1 + e) * compressed
    else:
        lost = work(mp.mpf(0), compressed)
        total = root(lambda p: work(compressed, p) + e**2 * lost, compressed, far)
    return total, friction(total)


def flown(of, times):
    """Place and angle at each of these times."""
    up, along = impulses(of)
    m, t, g, length = (mp.mpf(x) for x in (of.mass, of.angle, of.gravity, of.length))
    fall = mp.sqrt(2 * mp.mpf(of.height) / g)
    turned = 6 * (along * mp.sin(t) - up * mp.cos(t)) / (m * length)
    for now in map(mp.mpf, times):
        since = max(now - fall, mp.mpf(0))
        yield {
            "x": of.speed * now + along / m * since,
            "z": of.height + length * mp.sin(t) / 2 - g * now**2 / 2 + up / m * since,
            "angle": t + turned * since,
        }


def strikes_again(of):
    """When an end is back on the floor [s], on a grid of 1e-5 s."""
    up, along = map(float, impulses(of))
    since = np.arange(1, 200_000) * 1e-5
    fall = np.sqrt(2 * of.height / of.gravity)
    lifts = up / of.mass - of.gravity * fall
    z = of.length / 2 * np.sin(of.angle) + lifts * since - of.gravity * since**2 / 2
    turning = along * np.sin(of.angle) - up * np.cos(of.angle)
    angle = of.angle + 6 * turning / (of.mass * of.length) * since
    above = z > of.length / 2 * np.abs(np.sin(angle))
    return fall + since[np.argmin(above)]


@pytest.mark.parametrize("start", [name for name in STARTS if name != "jams at rest"])
def test_a_motion_is_known_until_an_end_strikes_again(start):
    """To the two thousandth part of the flight."""
    late = strikes_again(rod(start)) - rod(start).until
    assert -1e-5 < late < 2e-3


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("start", STARTS)
def test_40_digits(start, law):
    if start == "jams at rest" and law == "newton":
        pytest.skip("nothing is given back")
    of = rod(start, law=law)
    times = np.linspace(0.0, of.until, 5)
    exact = of.observe(times)
    doubt = of.uncertainty(times)
    with mp.workdps(40):
        for i, place in enumerate(flown(of, times)):
            for name, value in place.items():
                assert abs(value - mp.mpf(exact[name][i])) <= doubt[name][i], (name, i)
    assert max(value.max() for value in doubt.values()) < 2e-13


def energy_change(of):
    """Kinetic energy [J] that the impact adds: impulses times mean velocities of the end."""
    (a, b, c) = of.weights
    (_, up, along) = of.impact.impulses
    slip = 2 * of.speed + b * up + a * along
    falls = c * up + b * along - 2 * of.gravity * of.fall
    return (along * slip + up * falls) / 2


def test_what_the_laws_agree_on_and_what_an_impact_does_to_energy():
    totals = {
        s: {rod(s, law=law).impact.impulses[1] for law in LAWS} for s in ("slides", "smooth")
    }
    for values in totals.values():
        assert max(values) == pytest.approx(min(values), rel=1e-14)
    for start in STARTS:
        for e in (1e-3, 0.5, 1.0):
            if start != "jams at rest":
                assert energy_change(rod(start, restitution=e, law="energetic")) < 1e-12
    assert energy_change(rod("smooth", restitution=1.0)) == pytest.approx(0.0, abs=1e-13)
    assert energy_change(rod("sticks", restitution=1.0, law="newton")) > 0.49  # J
    assert [rod(s).impact.outcome for s in ("sticks", "slides", "jams")] == [
        "sticks",
        "slides",
        "sticks",
    ]


@pytest.mark.parametrize("chosen", matching_scenes("rod-impact"), ids=lambda s: s.name)
def test_every_method_makes_the_error_that_is_predicted(chosen):
    for how in methods():
        if meant(how, chosen) and limits_of(how.name).limit(chosen.name, how.name) is None:
            for step in (1e-3, 3e-4) if how.control == "step" else how.step_sizes[-1:]:
                found, _ = measure(case_of(chosen), how, step)
                judged = judge(found, case_of(chosen).system, how)
                assert judged.verdict == "predicted", (how.name, judged.reason)


def test_pymunk_s_rounding_uses_a_part_of_its_bound():
    """A tenth and more: ROUNDED is calibrated."""
    found = measure(case_of(scene("rod-impact/sticks")), method("pymunk/contact"), 1e-3)[0]
    error = found.errors["angle"]
    assert 0.1 < error.predicted.difference / error.left_open < 1.0


@pytest.mark.parametrize(
    ("name", "constant"),
    [("euler+coulomb", "IMPACT_PHASE_PER_STEP"), ("contact", "ROD_END_RADIUS")],
)
def test_a_slightly_different_contact_is_noticed(name, constant, monkeypatch):
    engine = "mujoco" if constant == "IMPACT_PHASE_PER_STEP" else "pymunk"
    how = method(f"{engine}/{name}")
    case = case_of(scene("rod-impact/sticks"))
    run = measure(case, how, 1e-3)[1]
    assert run is not None
    if constant == "IMPACT_PHASE_PER_STEP":
        monkeypatch.setattr(impacts, "IMPACT_PHASE_PER_STEP", 0.2001)
        changed = case.errors
    else:
        changed = rod_steps.rod_errors(replace(case.problem, restitution=0.5001))
    stepped = changed.at_step(scheme_of(case, how), 1e-3, run.times)
    differs = run.observables["angle"] - case.reference.observe(run.times)["angle"]
    assert np.abs(differs - stepped.errors["angle"]).max() > 1e-7
