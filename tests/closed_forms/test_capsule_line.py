"""The line manoeuvre: closed form against 40 digits and equations of motion, and sensitivity."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import direction_to
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import (
    LineManoeuvre,
    condition_number,
    printed_body_velocity,
)
from plumbob.tests.support.random_capsules import CHECK, LIMIT, LINE, lines

LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))
ONE_ROUNDING = 2.0**-53 * (1 + 1e-12)  # of the result, and the rounding of the comparison


def parameters(line):
    """What eqs. 11-22 depend on."""
    names = ("body_mass", "slider_mass", "friction", "gravity")
    found = {name: mpmath.mpf(getattr(line.capsule, name)) for name in names}
    return found | {name: mpmath.mpf(getattr(line, name)) for name in ("w1", "w2", "t1")}


def integrate(given, time):
    """Eqs. 11-14 integrated phase by phase, with 40 digits."""
    body, slider, friction, gravity, w1, w2, t1 = given.values()
    mu = slider / (body + slider)
    friction_limit = friction * gravity
    stop = t1 + w1 * t1 / w2
    rest = t1 + (mu * w1 - friction_limit) * t1 / (mu * w2 + friction_limit)
    x = v = xi = rate = now = mpmath.mpf(0)
    for end, w, sliding in ((t1, w1, 1), (rest, -w2, 1), (stop, -w2, 0)):
        span = min(end, time) - now
        if span > 0:
            a = (friction_limit - mu * w) * sliding
            x = x + v * span + a * span**2 / 2
            v = v + a * span
            xi = xi + rate * span + w * span**2 / 2
            rate = rate + w * span
            now += span
    found = {"displacement": x, "velocity": v, "stroke": xi, "stroke_rate": rate}
    return found | {"t2": stop, "t_star": rest}


def loads(line, given, exact):
    """N_i from the balance of forces and of moments about C, solved with 40 digits."""
    weight = given["slider_mass"] * given["gravity"]
    along = weight * (mpmath.mpf(line.start) + exact["stroke"])
    matrix = mpmath.matrix([[1, 1, 1], *zip(*line.capsule.supports, strict=True)])
    unit = mpmath.cos(mpmath.mpf(line.direction)), mpmath.sin(mpmath.mpf(line.direction))
    total = weight + given["body_mass"] * given["gravity"]
    return list(
        mpmath.lu_solve(matrix, mpmath.matrix([total, along * unit[0], along * unit[1]]))
    )


def agrees(line, names=("displacement", "stroke")):
    """Whether the manoeuvre has the numbers of physics.md for the check parameters: the decimals of
    seven parameters are rounded, w1 and w2 twice more, and the condition number gives the effect on
    the result."""
    allowed = 3 * condition_number(LINE) * 2.0**-53
    assert allowed < 1e-14
    wanted = {
        "displacement": -0.0055917,
        "stroke": 0.0817786125,
        "t2": 0.1425,
        "t_star": 0.19 / 3,
    }
    return all(abs(getattr(line, n) - wanted[n]) <= allowed * abs(wanted[n]) for n in names)


@pytest.mark.parametrize(
    "heading", [direction_to(CHECK, i) for i in (1, 2, 3)] + [0.9, 2.1, 3.9]
)
def test_check_values(heading):
    assert agrees(replace(LINE, direction=heading), ("displacement", "stroke", "t2", "t_star"))


@pytest.mark.parametrize(
    ("changes", "unlike"),
    [
        ({"friction": 0.3 * (1 + 1e-4)}, "displacement"),
        ({"slider_mass": 0.3001}, "displacement"),
    ],
)
def test_sensitivity(changes, unlike):
    """The stroke is set by w1, w2, t1 alone, the displacement is not."""
    wrong = replace(LINE, capsule=replace(CHECK, **changes))
    assert not agrees(wrong, (unlike,))
    assert agrees(wrong, ("stroke",))


def test_sensitivity_of_the_condition_number():
    """The largest relative change of the displacement over that of the parameters."""
    small, total = 1e-7, 0.0
    for name in ("body_mass", "slider_mass", "friction", "gravity", "w1", "w2", "t1"):
        owner = LINE if hasattr(LINE, name) else CHECK
        wrong = replace(owner, **{name: getattr(owner, name) * (1 + small)})
        line = wrong if isinstance(wrong, LineManoeuvre) else replace(LINE, capsule=wrong)
        total += abs(line.displacement / LINE.displacement - 1.0) / small
    # Second-order terms, a hundred or so times `small`.
    assert condition_number(LINE) == pytest.approx(total, rel=1e-5)


@given(lines())
def test_closed_form_has_one_rounding(line):
    with mpmath.workdps(40):
        exact = integrate(parameters(line), mpmath.mpf(2 * line.t2))
        for name in ("displacement", "stroke", "t2", "t_star"):
            found = mpmath.mpf(getattr(line, name))
            assert abs(found - exact[name]) <= ONE_ROUNDING * abs(exact[name])


@settings(max_examples=60)
@given(lines(), st.lists(st.floats(1e-9, 1.2), min_size=1, max_size=4), st.integers(0, 255))
def test_histories_within_their_uncertainty(line, parts, signs):
    """With every parameter and time changed by one rounding, in its own direction."""
    times = np.array([0.0, line.t1, line.t_star, line.t2, *(p * line.t2 for p in parts)])
    reference = line
    found = reference.observe(times)
    slack = reference.uncertainty(times)
    assert list(found) == list(slack)
    with mpmath.workdps(40):
        nudge = [1 + (1 if signs >> k & 1 else -1) * mpmath.mpf(2) ** -53 for k in range(8)]
        near = {n: p * nudge[k] for k, (n, p) in enumerate(parameters(line).items())}
        for i, time in enumerate(times):
            exact = integrate(near, mpmath.mpf(float(time)) * nudge[7])
            exact |= {
                f"normal_force_{k + 1}": n for k, n in enumerate(loads(line, near, exact))
            }
            for name in ("displacement", "velocity", "stroke", "stroke_rate", *LOADS):
                assert abs(found[name][i] - exact[name]) <= slack[name][i], name


def test_uncertainty_is_small():
    """An excessive bound would pass the test above."""
    times = np.linspace(0.0, 0.2, 50)
    observed = LINE.observe(times)
    for name, slack in LINE.uncertainty(times).items():
        assert slack.max() <= 6e-14 * max(1e-300, np.abs(observed[name]).max()), name


@given(lines(friction=0.0))
def test_without_friction_the_combined_centre_stays(line):
    """Eq. 15's upper bound on w2 then has no effect, because the body stops with the slider."""
    times = np.linspace(0.0, 1.5 * line.t2, 40)
    centre = line.at(times).displacement + line.capsule.mass_ratio * line.at(times).stroke
    assert np.abs(centre).max() <= 8 * 2.0**-52 * line.stroke  # the roundings of either term
    assert line.t_star == line.t2


def test_printed_velocity_contradicts_the_stopping_time():
    times = np.linspace(0.0, LINE.t2, 400)
    printed = printed_body_velocity(LINE, times)
    own = LINE.at(times).velocity
    pushing = times < LINE.t1
    np.testing.assert_array_equal(printed[pushing], own[pushing])
    assert abs(own[times > LINE.t_star]).max() == 0.0
    assert printed[times > LINE.t_star].max() < -0.1


def test_a_time_that_rounding_puts_before_rest_is_at_rest():
    # a step that begins there is one at rest: its friction is what holds the body
    times = np.array([math.nextafter(LINE.t_star, 0.0), LINE.t_star])
    early, there = LINE.friction_force(times)
    assert early == there == -CHECK.slider_mass * LINE.w2
    assert LINE.friction_force(times * (1.0 - 1e-12))[0] == CHECK.friction * CHECK.weight


@pytest.mark.parametrize("excess", [1e-6, 1e-12])
def test_push_just_above_its_threshold(excess):
    """w1 = f g/mu (1 + excess) leaves an exact difference, and a condition number that says so."""
    line = replace(LINE, w1=LIMIT * (1 + excess))
    # w1, f and g count once each, m and M by 1 - mu; roundings of w1 itself are 1e-16/excess.
    expected = (3 + 2 * (1 - CHECK.mass_ratio)) / excess
    near = excess + 5e-16 / excess
    assert condition_number(line) == pytest.approx(expected, rel=2 * near)
    friction_limit = CHECK.friction * CHECK.gravity
    assert line.displacement == pytest.approx(
        -0.5 * excess * friction_limit * 0.03**2, rel=near
    )
