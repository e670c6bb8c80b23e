"""The simple and the linear pendulum, described."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from plumbob.reports.view.about.description import Description, Label, Symbol

SYMBOLS = (
    Symbol("θ", "angle of the rod from hanging straight down", "rad"),
    Symbol("L, m", "length of the rod; mass of the bob", "m, kg"),
    Symbol("ξ", "damping rate", "1/s"),
    Symbol("A, Ω", "amplitude and angular frequency of the forcing", "rad/s², rad/s"),
    Symbol("g", "gravity", "m/s²"),
)
LABELS = (Label("θ", 192, 202), Label("L", 176, 122), Label("m", 103, 84))
LINES = ("M243 170V236", "M243 204Q206 206 214 152")
PICTURE = (
    "A ball on a rod that turns about the top of a post; θ is marked from hanging straight down."
)
FROM = "From a course notebook that integrates both by RK4 with a step of 0.05 s."
DESCRIPTIONS: Mapping[str, Description] = MappingProxyType(
    {
        "simple-pendulum": Description(
            (
                "A point mass on a rigid rod without weight swings about a horizontal axis.",
                "It is free, damped or forced, and swings, or goes over the top.",
            ),
            ("d²θ/dt² = A sin(Ωt) – ξ dθ/dt – (g/L) sin θ", "T = mL(dθ/dt)² + mg cos θ"),
            f"T is the tension of the rod. {FROM} Free, its motion is a Jacobi elliptic function; "
            "damped or forced, it is computed by two independent methods that must agree.",
            (*SYMBOLS, Symbol("T", "tension of the rod", "N")),
            LABELS,
            LINES,
            PICTURE,
        ),
        "linear-pendulum": Description(
            (
                "The same pendulum with θ in place of sin θ.",
                "It is a hinge with a spring, without gravity: what a pendulum is nearly, as long "
                "as it swings little.",
            ),
            ("d²θ/dt² = A sin(Ωt) – ξ dθ/dt – (g/L) θ",),
            f"Its motion has a closed form in every case. {FROM}",
            SYMBOLS,
            LABELS,
            LINES,
            PICTURE,
        ),
    }
)
