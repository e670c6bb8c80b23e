"""One colour and one marker for each method, wherever it appears.

The colour says the integrator and the marker the engine, so that the same integrator in two engines
is the same colour twice. The colours are told apart by every kind of colour vision (after Okabe and
Ito), and hold on a light and on a dark ground.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbob.engines.method import Method

# Fixed places, so that two pages agree whatever was measured; what is not here takes what is left.
INTEGRATORS = (
    ("euler", "#0072b2"),
    ("rk4", "#d55e00"),
    ("implicit", "#56b4e9"),
    ("implicitfast", "#009e73"),
    ("discrete", "#8a6a3a"),
    ("leapfrog", "#cc79a7"),
    ("dop853", "#e69f00"),
    ("radau", "#7e57c2"),
    ("lsoda", "#8f9a1c"),
    ("taylor", "#3aa0a0"),
    ("mine", "#e0304e"),
    ("closed-form", "#808080"),
)
OTHERS = ("#b05a8c", "#5a78d2", "#b8860b", "#6b8e23", "#708090")
ENGINES = (
    ("mujoco", "circle"),
    ("ode", "square"),
    ("pymunk", "diamond"),
    ("heyoka", "triangle-up"),
    ("exact", "star"),
)
SHAPES = ("triangle-down", "pentagon", "hexagon")
DASHES = ("solid", "dot", "dash", "dashdot")


@dataclass(frozen=True)
class Style:
    """How a method is drawn: colour, plotly's name of its marker, size [px], dashes of its line."""

    colour: str
    marker: str
    size: float
    dash: str


def styles(methods: Sequence[Method]) -> Mapping[str, Style]:
    """The style of each method by name; earlier ones get larger markers, so that curves that
    coincide are seen as rings."""
    colours, shapes = dict(INTEGRATORS), dict(ENGINES)
    found: dict[str, Style] = {}
    dashes: dict[tuple[str, str], int] = {}
    for rank, method in enumerate(methods):
        integrator = method.name.partition("/")[2].partition("+")[0]
        if integrator not in colours:
            colours[integrator] = OTHERS[(len(colours) - len(INTEGRATORS)) % len(OTHERS)]
        if method.engine not in shapes:
            shapes[method.engine] = SHAPES[(len(shapes) - len(ENGINES)) % len(SHAPES)]
        pair = (integrator, method.engine)
        dashes[pair] = dashes.get(pair, -1) + 1  # the same integrator with another contact profile
        found[method.name] = Style(
            colours[integrator],
            shapes[method.engine] + ("-open" if dashes[pair] % 2 else ""),
            max(5.0, 11.0 - 0.5 * rank),
            DASHES[dashes[pair] % len(DASHES)],
        )
    return found
