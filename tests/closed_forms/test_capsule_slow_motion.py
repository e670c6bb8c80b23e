"""Slow motion, holding under tilted gravity, and repeated manoeuvres."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import normal_forces, validity
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.analytic.systems.manoeuvres.residual_motion import coasting
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke, slow_return
from plumbob.analytic.systems.manoeuvres.tilted_hold import TiltedHold, tilt_angle
from plumbob.analytic.systems.slider_path import straight
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.rest import holding_limit
from plumbob.tests.support.fixed_step import mean_acceleration
from plumbob.tests.support.random_capsules import CHECK, LIMIT, LINE, capsules

angles = st.floats(-7.0, 7.0)
spans = st.floats(-0.2, 0.2)


@given(capsules(), angles, spans, angles, st.floats(0.0, 6.0))
def test_a_body_rests_up_to_the_threshold_and_no_further(capsule, place, span, pull, distance):
    """Friction balances a force through the combined centre if no rotation about any point gains
    energy: the work of the force is at most the dissipation, with equality in the limit of a
    translation."""
    slider = span * np.array([math.cos(place), math.sin(place)])
    centre = capsule.mass_ratio * slider
    limits = capsule.friction * normal_forces(capsule, slider[None])[0]
    force = capsule.weight * math.tan(tilt_angle(capsule))
    assert force == pytest.approx(capsule.slider_mass * capsule.holding_acceleration, rel=1e-14)
    across = np.array([-math.sin(pull), math.cos(pull)])
    for far in (10.0**distance, 1e6):
        pole = centre + far * across
        arms = np.hypot(*(np.asarray(capsule.supports) - pole).T)
        assert limits @ arms >= force * far * (1 - 1e-13)
    # Arms differ from `far` by (2 m)^2/(2 far) at most, beside the part that cancels: 2e-12 of it.
    assert limits @ arms == pytest.approx(force * far, rel=3e-12)


@given(spans, st.floats(0.05, 1.0), angles, st.booleans())
def test_slow_stroke_is_the_motion_of_its_acceleration(
    length, fraction, heading, there_and_back
):
    assume(abs(length) > 1e-6)
    slow = SlowStroke(CHECK, length, fraction, heading, -0.05, there_and_back)
    count = 4 if there_and_back else 2
    assert slow.duration == pytest.approx(
        count * math.sqrt(abs(length) / (fraction * LIMIT)), rel=1e-14
    )
    edges = np.linspace(0.0, slow.duration, count + 1)
    w = slow.at(edges[:-1] + edges[1] / 2).pull
    v = slow.relative_velocity(edges)
    span = edges[1]
    top = slow.acceleration * edges[1]
    places = slow.at(edges).stroke
    np.testing.assert_allclose(np.diff(v), w * span, rtol=0, atol=1e-14 * top)
    expected = v[:-1] * span + 0.5 * w * span**2
    np.testing.assert_allclose(np.diff(places), expected, rtol=0, atol=1e-14 * top * span)
    np.testing.assert_allclose(np.abs(w), fraction * LIMIT, rtol=1e-14)
    assert abs(places[2] - length) <= 1e-15
    assert abs(places[-1] - (0.0 if there_and_back else length)) <= 1e-15
    held = slow.observe(edges)
    assert np.abs(held["friction_force"]).max() <= CHECK.friction * CHECK.weight * (1 + 1e-15)
    assert held["stroke_rate"][-1] == held["friction_force"][-1] == 0.0
    np.testing.assert_array_equal(held["stroke"], places)


def test_tilted_gravity_pulls_as_specified():
    hold = TiltedHold(CHECK, 0.9, 0.7, (0.05, 0.02))
    held = hold.observe(np.array([0.0, 10.0]))
    down = 9.81 / math.hypot(1.0, 0.9 * 0.3)
    total = sum(held[f"normal_force_{i}"][0] for i in (1, 2, 3))
    assert total == pytest.approx(1.3 * down, rel=1e-14)
    assert held["friction_force"][1] == pytest.approx(-1.3 * 0.9 * 0.3 * down, rel=1e-14)
    assert held["displacement"][1] == 0.0


def test_a_repeated_motion_repeats_itself():
    repeated = RepeatedLine(LINE, 1000, fraction=0.9, pause=0.01)
    assert repeated.displacement == pytest.approx(-5.5917, rel=1e-14)
    times = np.linspace(0.0, repeated.period, 500, endpoint=False)
    late = times + 999 * repeated.period
    early = times < LINE.t2
    first = repeated.observe(times)
    last = repeated.observe(late)
    slack = repeated.uncertainty(late)
    for name, alone in LINE.observe(times).items():
        np.testing.assert_array_equal(first[name][early], alone[early])
        shift = 999 * LINE.displacement if name == "displacement" else 0.0
        assert np.all(np.abs(last[name] - first[name] - shift) <= slack[name] + 1e-300), name
    end = repeated.observe(np.array([repeated.duration, 2 * repeated.duration]))
    np.testing.assert_allclose(end["displacement"], repeated.displacement, rtol=1e-15)
    np.testing.assert_allclose(end["stroke"], 0.0, rtol=0, atol=1e-15)
    edges = np.linspace(0.0, 2 * repeated.period, 300)
    rates = np.cumsum(mean_acceleration(repeated, edges) * np.diff(edges))
    np.testing.assert_allclose(rates, repeated.relative_velocity(edges)[1:], atol=1e-13)


def test_slow_return_goes_back_over_the_same_path():
    back = slow_return(LINE, 0.5)
    assert back.ends[0] == LINE.ends[1]
    np.testing.assert_allclose(back.ends[1], LINE.ends[0], atol=1e-17)
    assert validity(CHECK, back.ends) == ()


@pytest.mark.parametrize(
    "motion",
    [
        SlowStroke(CHECK, 0.08, 0.9),
        TiltedHold(CHECK, 0.9),
        coasting(CHECK, (0.05, 0.0), (0.4 * math.cos(0.7), 0.4 * math.sin(0.7))),
    ],
    ids=lambda motion: motion.kind,
)
def test_rounding_allowances_are_small(motion):
    """An excessive bound would pass all the other tests."""
    times = np.linspace(0.0, 0.5, 200)
    observed = motion.observe(times)
    for name, slack in motion.uncertainty(times).items():
        assert slack.max() <= 6e-14 * np.abs(observed[name]).max(), name


@pytest.mark.parametrize("number", range(6))
def test_the_holding_limit_is_where_the_exact_motion_begins(number):
    """On any path, not along lines through C alone: a thousandth more moves the body."""
    rng = np.random.default_rng([3, number])
    place = complex(*rng.uniform(-0.08, 0.08, 2))
    direction = rng.uniform(0.0, 2.0 * math.pi)
    limit = holding_limit(CHECK, place, direction)
    assert limit <= CHECK.holding_acceleration * (1.0 + 1e-12)
    for factor, moves in ((0.999, False), (1.001, True)):
        w = factor * limit
        path = straight((place.real, place.imag), direction, (w, -0.5 * w), (1e-6, 2e-6))
        assert (three_point_motion(CHECK, path).events[0].mode != "rest") == moves
