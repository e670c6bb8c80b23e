"""One colour and one marker for each method, the same in all figures.

The colour stands for the integrator or the contact model, and the marker for the engine, so an
integrator has the same colour in two engines; two methods of one colour have two markers. Default
settings are red and recommended settings blue, as in replays. The colours are distinct for a reader
who sees no green, on a light and on a dark background (after Okabe and Ito).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

from plumbob.engines.method import USER_METHOD

BLUE, RED, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PINK, BROWN, VIOLET = "#56b4e9", "#cc79a7", "#8a6a3a", "#6f4bd0"
GREY = "#5f5f5f"  # bands, and references that are no predictions: no method has it
INK = "#1d2329"  # colour of predictions; a dark page has its light ink in its place
# colours for curves without a fixed colour, in this order
COLOURS = (BLUE, ORANGE, GREEN, PINK, SKY, RED, VIOLET, BROWN)

# The colours are fixed so that two pages agree, whatever was measured. An integrator that is not
# listed takes one of `OTHER_COLOURS`.
INTEGRATOR_COLOURS = (
    ("euler", RED),
    ("rk4", BLUE),
    ("implicit", SKY),
    ("implicitfast", GREEN),
    ("discrete", BROWN),
    ("leapfrog", PINK),
    ("dop853", ORANGE),
    ("radau", VIOLET),
    ("lsoda", BROWN),
    ("taylor", GREEN),
    (USER_METHOD.partition("/")[2], VIOLET),
    ("closed-form", GREY),
)
OTHER_COLOURS = (VIOLET, PINK, BROWN, ORANGE, SKY)
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
ALL_MARKERS = tuple(
    shape + ending
    for ending, shape in product(("", "-open"), (*dict(ENGINE_MARKERS).values(), *SHAPES))
)
DECADES = 6  # number of coloured decades below 1: all errors up to 1e-6 have the first colour


@dataclass(frozen=True)
class Style:
    """The drawing style of a method."""

    colour: str
    marker: str  # plotly's name of the marker
    size: float  # [px] size of the marker


def styles(names: Iterable[str]) -> Mapping[str, Style]:
    """Returns the style of each method by name. Earlier methods have larger markers, so that the
    marks of coinciding curves show as rings."""
    colours = dict(INTEGRATOR_COLOURS)
    shapes = dict(ENGINE_MARKERS)
    by_method: dict[str, Style] = {}
    markers_by_colour: dict[str, list[str]] = {}
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
        earlier = markers_by_colour.setdefault(colour, [])
        marker = _free_marker(shapes[engine], earlier)
        by_method[name] = Style(
            colour=colour,
            marker=marker,
            size=max(5.0, 11.0 - 0.5 * rank),
        )
        earlier.append(marker)
    return by_method


def _free_marker(shape: str, used: Sequence[str]) -> str:
    """Returns the marker of a method of an engine with this `shape`: the shape, else the open
    shape, else any marker, whichever first is not among the `used` markers of its colour; the shape
    if none is left."""
    candidates = (shape, f"{shape}-open", *ALL_MARKERS)
    return next((marker for marker in candidates if marker not in used), shape)


def size_class(error: float) -> str:
    """Returns the CSS class of a table cell for the decade of its relative error: size-a for the
    smallest errors, size-h for every error above 1, also if it is infinite."""
    decade = math.ceil(math.log10(max(error, 1e-99)) - 1e-9) if error < 1.0 else 0
    rank = DECADES + 1 if error > 1.0 else max(DECADES + decade, 0)
    return f"size-{'abcdefgh'[rank]}"
