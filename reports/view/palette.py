"""One colour and one marker for each method, the same in all figures.

The colour stands for the integrator or the contact model, and the marker for the engine, so an
integrator has the same colour in two engines. Default settings are red and recommended settings
blue, as in replays. The colours are distinct under every kind of colour vision (after Okabe and
Ito), on a light and on a dark background.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from plumbob.engines.method import USER_METHOD

BLUE, RED, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PINK, GREY = "#56b4e9", "#cc79a7", "#808080"
PLUM, OLIVE, PERIWINKLE = "#b05a8c", "#6b8e23", "#5a78d2"
# colours for curves without a fixed colour, in this order
COLOURS = (BLUE, ORANGE, GREEN, PINK, SKY, RED, OLIVE, PERIWINKLE, GREY)

# The colours are fixed so that two pages agree, whatever was measured. An integrator that is not
# listed takes one of `OTHER_COLOURS`.
INTEGRATOR_COLOURS = (
    ("euler", RED),
    ("rk4", BLUE),
    ("implicit", SKY),
    ("implicitfast", GREEN),
    ("discrete", "#8a6a3a"),
    ("leapfrog", PINK),
    ("dop853", ORANGE),
    ("radau", "#7e57c2"),
    ("lsoda", "#8f9a1c"),
    ("taylor", "#3aa0a0"),
    (USER_METHOD.partition("/")[2], "#e0304e"),
    ("closed-form", GREY),
)
OTHER_COLOURS = (PLUM, PERIWINKLE, "#b8860b", OLIVE, "#708090")
OF_METHODS = MappingProxyType(
    {
        "mujoco/euler": RED,
        "mujoco/euler+elliptic": ORANGE,
        "mujoco/euler+coulomb": BLUE,
        "mujoco/rk4+coulomb": GREEN,
        "mujoco/euler+reduced": SKY,
        "mujoco/euler+tall": RED,
        "pymunk/feet": PINK,
        "pymunk/side": GREEN,
    }
)
"""Colours of methods that differ by their contact model rather than by their integrator."""
ENGINE_MARKERS = (
    ("mujoco", "circle"),
    ("ode", "square"),
    ("pymunk", "diamond"),
    ("heyoka", "triangle-up"),
    ("exact", "star"),
)
SHAPES = ("triangle-down", "pentagon", "hexagon")
DECADES = 6  # number of coloured decades below 1: all errors up to 1e-6 have the first colour
LINE_DASHES = ("solid", "dot", "dash", "dashdot")


@dataclass(frozen=True)
class Style:
    """The drawing style of a method."""

    colour: str
    marker: str  # plotly's name of the marker
    size: float  # [px] size of the marker
    dash: str  # plotly's name of the line's dashes


def styles(names: Iterable[str]) -> Mapping[str, Style]:
    """Returns the style of each method by name. Earlier methods have larger markers, so that the
    marks of coinciding curves show as rings."""
    colours = dict(INTEGRATOR_COLOURS)
    shapes = dict(ENGINE_MARKERS)
    by_method: dict[str, Style] = {}
    # methods so far: each has other dashes than the others
    earlier_by_colour: dict[str, int] = {}
    for rank, name in enumerate(names):
        engine, _, variant = name.partition("/")
        integrator = variant.partition("+")[0]
        if integrator not in colours:
            colours[integrator] = OTHER_COLOURS[
                (len(colours) - len(INTEGRATOR_COLOURS)) % len(OTHER_COLOURS)
            ]
        if engine not in shapes:
            shapes[engine] = SHAPES[(len(shapes) - len(ENGINE_MARKERS)) % len(SHAPES)]
        colour = OF_METHODS.get(name, colours[integrator])
        earlier = earlier_by_colour.get(colour, 0)
        earlier_by_colour[colour] = earlier + 1
        by_method[name] = Style(
            colour=colour,
            marker=shapes[engine] + ("-open" if earlier % 2 else ""),
            size=max(5.0, 11.0 - 0.5 * rank),
            dash=LINE_DASHES[earlier % len(LINE_DASHES)],
        )
    return by_method


def size_class(error: float) -> str:
    """Returns the CSS class of a table cell for the decade of its relative error: size-a for the
    smallest errors, size-h for every error above 1, also if it is infinite."""
    decade = math.ceil(math.log10(max(error, 1e-99)) - 1e-9) if error < 1.0 else 0
    rank = DECADES + 1 if error > 1.0 else max(DECADES + decade, 0)
    return f"size-{'abcdefgh'[rank]}"
