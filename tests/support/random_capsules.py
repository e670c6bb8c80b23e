"""Capsules, line manoeuvres and scenes of them that tests vary, at random or as they say."""

import math
from dataclasses import replace

from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre

CHECK = Capsule(1.0, 0.3, 0.02, ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15)), 0.3, 9.81)
LIMIT = CHECK.holding_acceleration
LINE = LineManoeuvre(CHECK, 3 * LIMIT, 0.8 * LIMIT, 0.03)


@st.composite
def triangles(draw, shortest, longest):
    """Three supports round C at these distances."""
    gaps = [draw(st.floats(0.6, 1.0)) for _ in range(3)]  # each comes to less than half a turn
    angles = [2 * math.pi * sum(gaps[: i + 1]) / sum(gaps) for i in range(3)]
    arms = [draw(st.floats(shortest, longest)) for _ in range(3)]
    a, b, c = ((r * math.cos(p), r * math.sin(p)) for r, p in zip(arms, angles, strict=True))
    return a, b, c


@st.composite
def capsules(draw, friction=None):
    """Any capsule with C inside its triangle of arms 0.5 to 2 m; m/M from 1e-3 to 1e3."""
    ratio = 10.0 ** draw(st.floats(-3, 3))
    coefficient = draw(st.floats(0.01, 2.0)) if friction is None else friction
    supports = draw(triangles(0.5, 2.0))
    body = draw(st.floats(0.1, 10.0))
    return Capsule(body, ratio * body, 0.02, supports, coefficient, 9.81)


@st.composite
def lines(draw, friction=None):
    """Any valid manoeuvre, along any line; the push from just above its threshold to far above."""
    capsule = draw(capsules(friction))
    limit = capsule.holding_acceleration or 1.0
    w1 = limit * (1.0 + 10.0 ** draw(st.floats(-6, 2)))
    w2 = limit * draw(st.floats(0.01, 1.0) | st.just(1.0))
    t1 = draw(st.floats(1e-3, 1.0))
    heading = draw(st.floats(-7.0, 7.0))
    stroke = w1 * (w1 + w2) * t1**2 / (2 * w2)
    size = 10 * capsule.mass_ratio * stroke
    a, b, c = ((size * x, size * y) for x, y in capsule.supports)
    start = draw(st.floats(-1.0, 0.1)) * stroke
    return LineManoeuvre(replace(capsule, supports=(a, b, c)), w1, w2, t1, heading, start)
