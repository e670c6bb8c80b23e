"""The capsule: a body on three supports with a moving point mass inside (Chernousko 2020)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF as ROUNDOFF
from plumbob.analytic.parameters import ParameterError, check_fields, numbers
from plumbob.analytic.reference import Array

Point = tuple[float, float]
NORMAL_FORCES = ("normal_force_1", "normal_force_2", "normal_force_3")

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])  # [m] from C

# Below this height over its longest side a triangle gives support loads to fewer than 7 digits.
FLATTEST = 1e-9
# Rounding of a load in units of ROUNDOFF times the weight: the root of the sum of the squares of
# errors whose sum is 32 at most.
LOAD_ROUNDINGS = 12.0


@dataclass(frozen=True)
class Capsule:
    """Body P with its centre of mass at C, slider Q, and three Coulomb supports A_i.

    body_mass M [kg]; slider_mass m [kg]; inertia J of the body about the vertical through C
    [kg m^2]; supports A_i relative to C in body axes [m]; friction f (0 allowed); gravity
    g [m/s^2]. Heights of C and Q are zero. Raises ParameterError. Chernousko 2020, eqs. 1-10.
    """

    body_mass: float
    slider_mass: float
    inertia: float
    supports: tuple[Point, Point, Point]
    friction: float
    gravity: float

    def __post_init__(self) -> None:
        positives = ("body_mass", "slider_mass", "inertia", "gravity")
        check_fields(self, positives, ("friction",), ("supports",))
        object.__setattr__(self, "supports", _triangle("supports", self.supports))

    @property
    def mass_ratio(self) -> float:
        """mu = m/(M + m) (Chernousko 2020, eq. 10)."""
        return self.slider_mass / (self.body_mass + self.slider_mass)

    @property
    def weight(self) -> float:
        """(M + m) g [N], the sum of the normal forces (Chernousko 2020, eq. 7)."""
        return (self.body_mass + self.slider_mass) * self.gravity

    @property
    def holding_acceleration(self) -> float:
        """f g/mu [m/s^2], the largest |w| along a line through C that leaves the body at rest
        (Chernousko 2020, eq. 21)."""
        return self.friction * self.weight / self.slider_mass


@dataclass(frozen=True)
class Arc:
    """Piece of the circle of `radius` [m] about C, from angle `start` to angle `end` [rad]."""

    radius: float
    start: float
    end: float


Path = Sequence[Point | Arc]
"""The corners of straight pieces of the slider's path relative to C [m], and its arcs."""


@dataclass(frozen=True)
class SourceAssumption:
    """Whether C, and Q along its whole path, lie inside the triangle, as the source assumes; this
    is sufficient for positive normal forces, not necessary."""

    com_inside: bool
    slider_inside: bool


def _triangle(name: str, supports: Any) -> tuple[Point, Point, Point]:
    a1, a2, a3 = numbers(name, supports, (3, 2), "three points (x, y)")
    longest = max(math.dist(a1, a2), math.dist(a2, a3), math.dist(a3, a1))
    doubled_area = (a2[0] - a1[0]) * (a3[1] - a1[1]) - (a2[1] - a1[1]) * (a3[0] - a1[0])
    if not abs(doubled_area) > FLATTEST * longest**2:
        raise ParameterError(name, supports, "a triangle, not three points on a line")
    return a1, a2, a3


def direction_to(capsule: Capsule, support: int) -> float:
    """Angle [rad] of the line from C to A_1, A_2 or A_3, from the body's x axis.

    Raises ParameterError if `support` is not 1, 2 or 3, or lies at C.
    """
    if type(support) is not int or support not in (1, 2, 3):
        raise ParameterError("support", support, "1, 2 or 3")
    x, y = capsule.supports[support - 1]
    if x == 0.0 == y:
        raise ParameterError("support", support, "a support away from C, to give a direction")
    return math.atan2(y, x)


def load_fractions(capsule: Capsule, centres: Array) -> Array:
    """Fraction of the weight on each support with the combined centre of mass at `centres` [m],
    shape (n, 2): barycentric coordinates, shape (n, 3), of either sign, with sum 1."""
    corners = np.asarray(capsule.supports)
    ends = corners - np.asarray(centres, dtype=np.float64)[..., None, :]
    after = ends[..., (1, 2, 0), :]
    last = ends[..., (2, 0, 1), :]
    areas = after[..., 0] * last[..., 1] - after[..., 1] * last[..., 0]
    (ux, uy) = corners[1] - corners[0]
    (vx, vy) = corners[2] - corners[0]
    return np.asarray(areas / (ux * vy - uy * vx))


def normal_forces(capsule: Capsule, slider_positions: Array) -> Array:
    """Static normal forces N_i [N], shape (n, 3), with the slider at `slider_positions` relative
    to C [m], shape (n, 2): M at C and m at Q weigh as M + m at mu r (Chernousko 2020, eq. 7)."""
    centres = capsule.mass_ratio * np.asarray(slider_positions, dtype=np.float64)
    return capsule.weight * load_fractions(capsule, centres)


def by_support(forces: Array) -> dict[str, Array]:
    """Normal forces [N], shape (n, 3), as the observables normal_force_1..3, shape (n,) each."""
    return dict(zip(NORMAL_FORCES, forces.T, strict=True))


def load_gradient(capsule: Capsule) -> Array:
    """Change of the N_i with the slider's place [N/m], along x and y, shape (2, 3)."""
    here, x, y = normal_forces(capsule, CORNERS)
    return np.stack([x - here, y - here])


def load_slopes(capsule: Capsule, direction: float) -> Array:
    """Change of the N_i as the slider moves along `direction` [rad, from the body's x axis], [N/m],
    shape (3,): the same at every place."""
    return np.asarray([math.cos(direction), math.sin(direction)] @ load_gradient(capsule))


def longest_stroke(
    capsule: Capsule, direction: float, least: float = 0.0
) -> tuple[float, float]:
    """Where the slider's line at `direction` [rad] through C leaves the places with every N_i above
    `least` of what it is with the slider at C, from C [m]: the ends of the longest stroke, which
    are themselves outside. Raises ParameterError where C is outside the triangle."""
    loads = normal_forces(capsule, np.zeros((1, 2)))[0]
    if not loads.min() > 0.0:
        raise ParameterError("supports", capsule.supports, "a triangle with C inside")
    falls = -load_slopes(capsule, direction) / ((1.0 - least) * loads)
    return 1.0 / float(falls.min()), 1.0 / float(falls.max())


def steepest_load(capsule: Capsule) -> float:
    """Largest change of any N_i with the slider's place [N/m]."""
    return float(np.hypot(*load_gradient(capsule)).max())


def normal_force_uncertainty(capsule: Capsule, reach: float, moved: Any = 0.0) -> Any:
    """Bound on the error of each N_i [N] from rounded parameters and arithmetic, with the slider
    within `reach` of C [m], in places that it is `moved` from [m], shape of these: a quotient of
    areas, which has few digits in a flat triangle. The squares of its rounding errors add."""
    corners = np.asarray(capsule.supports)
    (ux, uy) = corners[1] - corners[0]
    (vx, vy) = corners[2] - corners[0]
    size = float(np.abs(corners).max()) + capsule.mass_ratio * reach
    flatness = size**2 / abs(ux * vy - uy * vx)
    rounded = LOAD_ROUNDINGS * ROUNDOFF * capsule.weight * flatness * (1 + 4 * flatness)
    return rounded + steepest_load(capsule) * moved


def _turning_points(capsule: Capsule, piece: Point | Arc) -> Array:
    """Slider positions, shape (n, 2), among which every support load has its minimum on
    `piece`: a load is affine in the position, so a cosine of the angle along an arc."""
    if not isinstance(piece, Arc):
        return np.array([piece], dtype=np.float64)
    low, high = sorted((piece.start, piece.end))
    here, x, y = load_fractions(capsule, CORNERS)
    steepest_fall = np.arctan2(here - y, here - x)
    inner = low + np.mod(steepest_fall - low, 2 * math.pi)
    angles = np.concatenate([[low, high], inner[inner < high]])
    return piece.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _lowest(capsule: Capsule, path: Path, reach: float) -> tuple[Array, Array]:
    if not path:
        raise ParameterError("path", path, "at least one point or Arc")
    candidates = np.concatenate([_turning_points(capsule, piece) for piece in path])
    fractions = load_fractions(capsule, reach * candidates)
    where = np.argmin(fractions, axis=0)
    return np.min(fractions, axis=0), np.asarray(candidates[where])


def lowest_normal_forces(capsule: Capsule, path: Path) -> tuple[Array, Array]:
    """Exact minimum of each N_i along `path` [N], shape (3,), and the slider's positions there
    relative to C [m], shape (3, 2). Raises ParameterError on an empty path."""
    fractions, where = _lowest(capsule, path, capsule.mass_ratio)
    return capsule.weight * fractions, where


def validity(capsule: Capsule, path: Path) -> tuple[ParameterError, ...]:
    """Violations on `path` of what the equations require, as errors to raise or to print: a normal
    force above zero at every support along the whole path. Empty when it is valid."""
    forces, where = lowest_normal_forces(capsule, path)
    return tuple(
        ParameterError(
            NORMAL_FORCES[i],
            float(forces[i]),
            "greater than 0 along the slider's whole path"
            f" (lowest at ({where[i, 0]:.6g}, {where[i, 1]:.6g}) m from C)",
        )
        for i in range(3)
        if not forces[i] > 0.0
    )


def check_loads(capsule: Capsule, path: Path) -> None:
    """Raise the first violation on `path`, where there is one."""
    for breach in validity(capsule, path):
        raise breach


def source_assumption(capsule: Capsule, path: Path) -> SourceAssumption:
    """Whether the source's stronger assumption holds along `path` (Chernousko 2020, section
    "Mechanical system")."""
    slider, _ = _lowest(capsule, path, 1.0)
    com = load_fractions(capsule, np.zeros(2))
    return SourceAssumption(bool(np.all(com > 0.0)), bool(np.all(slider > 0.0)))
