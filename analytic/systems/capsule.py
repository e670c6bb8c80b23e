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

PlanePoint = tuple[float, float]
NORMAL_FORCES = ("normal_force_1", "normal_force_2", "normal_force_3")

# [m] C, and the positions 1 m from C along x and y: three values give an affine function
UNIT_POSITIONS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])

# Smallest ratio of the height of a triangle of supports to its longest side: a flatter triangle
# gives support loads with fewer than 7 digits.
SMALLEST_HEIGHT = 1e-9
# Rounding of a load in units of ROUNDOFF times the weight: the root of the sum of squares of errors
# that add up to at most 32.
LOAD_ROUNDINGS = 12.0


@dataclass(frozen=True)
class Capsule:
    """Body P with its centre of mass at C, slider Q, and three Coulomb supports A_i.

    body_mass M [kg]; slider_mass m [kg]; inertia J of the body about the vertical through C [kg
    m^2]; supports A_i relative to C in body axes [m]; friction coefficient f (may be 0); gravity g
    [m/s^2]. C and Q have no height above the plane. Raises ParameterError. Chernousko 2020, eqs.
    1-10.
    """

    body_mass: float
    slider_mass: float
    inertia: float
    supports: tuple[PlanePoint, PlanePoint, PlanePoint]
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
        """Weight (M + m) g [N], the sum of the normal forces (Chernousko 2020, eq. 7)."""
        return (self.body_mass + self.slider_mass) * self.gravity

    @property
    def holding_acceleration(self) -> float:
        """f g/mu [m/s^2], the largest acceleration |w| of the slider along a line through C that
        leaves the body at rest (Chernousko 2020, eq. 21)."""
        return self.friction * self.weight / self.slider_mass


@dataclass(frozen=True)
class Arc:
    """A piece of the circle of `radius` [m] about C, from angle `start` to angle `end` [rad]."""

    radius: float
    start: float
    end: float


CapsulePath = Sequence[PlanePoint | Arc]
"""The corners of straight pieces of the slider's path relative to C [m], and its arcs."""


@dataclass(frozen=True)
class SourceAssumption:
    """The source's assumption: C, and Q along its whole path, lie inside the triangle of supports.
    The two parts are stated apart. It is sufficient for positive normal forces, but not necessary.
    """

    com_inside: bool
    slider_inside: bool


def _triangle(name: str, supports: Any) -> tuple[PlanePoint, PlanePoint, PlanePoint]:
    """Returns the supports as tuples. Raises ParameterError if they are not a triangle."""
    a1, a2, a3 = numbers(name, supports, (3, 2), "three points (x, y)")
    longest = max(math.dist(a1, a2), math.dist(a2, a3), math.dist(a3, a1))
    doubled_area = (a2[0] - a1[0]) * (a3[1] - a1[1]) - (a2[1] - a1[1]) * (a3[0] - a1[0])
    if not abs(doubled_area) > SMALLEST_HEIGHT * longest**2:
        raise ParameterError(name, supports, "a triangle, not three points on a line")
    return a1, a2, a3


def direction_to(capsule: Capsule, support: int) -> float:
    """Returns the angle [rad] of the line from C to A_1, A_2 or A_3, from the body's x axis.

    Raises ParameterError if `support` is not 1, 2 or 3, or lies at C.
    """
    if type(support) is not int or support not in (1, 2, 3):
        raise ParameterError("support", support, "1, 2 or 3")
    x, y = capsule.supports[support - 1]
    if x == 0.0 == y:
        raise ParameterError("support", support, "a support away from C, to give a direction")
    return math.atan2(y, x)


def load_fractions(capsule: Capsule, centres: Array) -> Array:
    """Returns the fraction of the weight on each support, shape (n, 3), with the combined centre of
    mass at `centres` [m], shape (n, 2). The fractions are barycentric coordinates, of either sign,
    with sum 1."""
    corners = np.asarray(capsule.supports)
    arms = corners - np.asarray(centres, dtype=np.float64)[..., None, :]
    second = arms[..., (1, 2, 0), :]
    third = arms[..., (2, 0, 1), :]
    areas = second[..., 0] * third[..., 1] - second[..., 1] * third[..., 0]
    return np.asarray(areas / _doubled_area(corners))


def _doubled_area(corners: Array) -> float:
    """Returns twice the area [m^2] of the triangle of supports, shape (3, 2); negative if they are
    clockwise."""
    ux, uy = corners[1] - corners[0]
    vx, vy = corners[2] - corners[0]
    return float(ux * vy - uy * vx)


def normal_forces(capsule: Capsule, slider_positions: Array) -> Array:
    """Returns the static normal forces N_i [N], shape (n, 3), with the slider at `slider_positions`
    relative to C [m], shape (n, 2). M at C and m at Q act like M + m at mu r (Chernousko 2020, eq.
    7)."""
    centres = capsule.mass_ratio * np.asarray(slider_positions, dtype=np.float64)
    return capsule.weight * load_fractions(capsule, centres)


def by_support(forces: Array) -> dict[str, Array]:
    """Returns normal forces [N], shape (n, 3), as observables normal_force_1..3, shape
    (n,) each."""
    return dict(zip(NORMAL_FORCES, forces.T, strict=True))


def load_gradient(capsule: Capsule) -> Array:
    """Returns the derivatives of the N_i by the slider's x and y [N/m], shape (2, 3)."""
    at_c, along_x, along_y = normal_forces(capsule, UNIT_POSITIONS)
    return np.stack([along_x - at_c, along_y - at_c])


def load_slopes(capsule: Capsule, direction: float) -> Array:
    """Returns the derivatives of the N_i by the slider's displacement along `direction` [rad, from
    the body's x axis], [N/m], shape (3,). They do not depend on the slider's place."""
    unit = [math.cos(direction), math.sin(direction)]
    return np.asarray(unit @ load_gradient(capsule))


def longest_stroke(
    capsule: Capsule, direction: float, least: float = 0.0
) -> tuple[float, float]:
    """Returns the two ends [m] of the longest stroke on the line at `direction` [rad] through C,
    signed from C. At an end, the first N_i falls to the part `least` of its value with the slider
    at C. Raises ParameterError if C is outside the triangle."""
    loads = normal_forces(capsule, np.zeros((1, 2)))[0]
    if not loads.min() > 0.0:
        raise ParameterError("supports", capsule.supports, "a triangle with C inside")
    relative_falls = -load_slopes(capsule, direction) / ((1.0 - least) * loads)
    return 1.0 / float(relative_falls.min()), 1.0 / float(relative_falls.max())


def steepest_load(capsule: Capsule) -> float:
    """Returns the largest derivative of any N_i by the slider's displacement [N/m]."""
    return float(np.hypot(*load_gradient(capsule)).max())


def normal_force_uncertainty(capsule: Capsule, reach: float, moved: Any = 0.0) -> Any:
    """Returns a bound on the error of each N_i [N] by rounded parameters and arithmetic. The slider
    is within `reach` of C [m]; its place has the error `moved` [m], which gives the result's shape.

    A load is a quotient of areas, which has few digits in a flat triangle. The squares of its
    rounding errors are added.
    """
    corners = np.asarray(capsule.supports)
    size = float(np.abs(corners).max()) + capsule.mass_ratio * reach
    flatness = size**2 / abs(_doubled_area(corners))
    rounded = LOAD_ROUNDINGS * ROUNDOFF * capsule.weight * flatness * (1 + 4 * flatness)
    return rounded + steepest_load(capsule) * moved


def _minimum_candidates(capsule: Capsule, piece: PlanePoint | Arc) -> Array:
    """Returns slider positions, shape (n, 2), among which every support load has its minimum on
    `piece`.

    A load is affine in the position, so along an arc it is a cosine of the angle: its minimum is at
    an end of the arc, or at the angle of its steepest fall if this is on the arc.
    """
    if not isinstance(piece, Arc):
        return np.array([piece], dtype=np.float64)
    low, high = sorted((piece.start, piece.end))
    at_c, along_x, along_y = load_fractions(capsule, UNIT_POSITIONS)
    steepest_fall = np.arctan2(at_c - along_y, at_c - along_x)
    inner = low + np.mod(steepest_fall - low, 2 * math.pi)
    angles = np.concatenate([[low, high], inner[inner < high]])
    return piece.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _lowest_fractions(capsule: Capsule, path: CapsulePath, reach: float) -> tuple[Array, Array]:
    """Returns the minimum along `path` of each barycentric coordinate of `reach` times the slider's
    position, shape (3,), and the positions of the minima, shape (3, 2)."""
    if not path:
        raise ParameterError("path", path, "at least one point or Arc")
    candidates = np.concatenate([_minimum_candidates(capsule, piece) for piece in path])
    fractions = load_fractions(capsule, reach * candidates)
    indices = np.argmin(fractions, axis=0)
    return np.min(fractions, axis=0), np.asarray(candidates[indices])


def lowest_normal_forces(capsule: Capsule, path: CapsulePath) -> tuple[Array, Array]:
    """Returns the exact minimum of each N_i along `path` [N], shape (3,), and the slider's
    positions there relative to C [m], shape (3, 2). Raises ParameterError if the path is empty."""
    fractions, places = _lowest_fractions(capsule, path, capsule.mass_ratio)
    return capsule.weight * fractions, places


def validity(capsule: Capsule, path: CapsulePath) -> tuple[ParameterError, ...]:
    """Returns the violations on `path` as errors, to raise or to print. The equations require a
    positive normal force at every support along the whole path. The result is empty if they hold.
    """
    forces, places = lowest_normal_forces(capsule, path)
    violations = list[ParameterError]()
    for name, force, (x, y) in zip(NORMAL_FORCES, forces.tolist(), places, strict=True):
        if not force > 0.0:
            lowest = f"(lowest at ({x:.6g}, {y:.6g}) m from C)"
            need = f"greater than 0 along the slider's whole path {lowest}"
            violations.append(ParameterError(name, force, need))
    return tuple(violations)


def check_loads(capsule: Capsule, path: CapsulePath) -> None:
    """Raises the first violation on `path`, if there is one."""
    for violation in validity(capsule, path):
        raise violation


def source_assumption(capsule: Capsule, path: CapsulePath) -> SourceAssumption:
    """Returns whether the source's stronger assumption holds along `path` (Chernousko 2020, section
    "Mechanical system")."""
    of_slider, _ = _lowest_fractions(capsule, path, 1.0)
    of_c = load_fractions(capsule, np.zeros(2))
    return SourceAssumption(
        com_inside=bool(np.all(of_c > 0.0)), slider_inside=bool(np.all(of_slider > 0.0))
    )
