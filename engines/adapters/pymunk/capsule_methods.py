"""The methods for the capsule: three models, and pymunk's one integrator."""

from __future__ import annotations

from plumbob.analytic.errors.schemes import EULER, Scheme
from plumbob.engines.method import Method

SCHEME = Scheme(EULER, position_first=True)
# Turned about, a line stays a line, and the side view need not run every heading.
ONE_LINE = (
    *("capsule-line/[!h]*", "capsule-line/heavy-slider", "capsule-hold", "capsule-train"),
    "capsule-coast/translation",
)
CAPSULE = (
    Method(
        "pymunk/feet",
        SCHEME,
        1,
        settings={"model": "feet", "iterations": 50},
        systems=("capsule-*",),
    ),
    Method(
        "pymunk/pivots",
        SCHEME,
        1,
        settings={"model": "pivots", "iterations": 50},
        systems=("capsule-*",),
    ),
    Method(
        "pymunk/side", SCHEME, 1, settings={"model": "side", "iterations": 30}, systems=ONE_LINE
    ),
)
