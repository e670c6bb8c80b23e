"""Further statements of the source on its motions, and the numbers that judge them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.uniformity import uniformity_from_bottom
from plumbob.analytic.systems.platform_energy import energies
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, closed_forms
from plumbob.reports.analyses.measurements import FULL_TURN, in_double

MAXIMUM_SAMPLES = 20_000  # per period or half turn, so that a maximum is known to eight digits
SPEED_DIFFERENCES = (0.05, 0.10)  # relative distances from the initial speed
# scene of a rotation 1e-6 above the barrier, relative
BARELY_OVER_BARRIER = "cone-pendulum/above-barrier-1e-6"
VECTORS = (0.7, 5.0, 0.2)  # theta [rad], dθ/dt [rad/s] and X [m] at which (4) is evaluated
SPEED_MAP_RATES = np.linspace(0.0, 100.0, 41)  # [rad/s] platform rates of the maps
GRID_AXES = (("S", np.linspace(0.02, 0.3, 36)), ("Y", np.linspace(0.0, 0.35, 36)))  # [m]
PERIOD_TOLERANCE = 1e-12  # largest relative error of a period by the trapezoid rule


def numbers() -> Record:
    """Returns the numbers that judge the statements, by the source and by the exact motions."""
    resting = closed_forms(RESTING).correct
    turning = closed_forms(ROTATING).correct
    problem = closed_forms(ROTATING).problem
    others = (problem, replace(problem, pivot_y=0.0), replace(problem, platform_rate=10.0))
    z = np.linspace(
        0.0, 1.0, MAXIMUM_SAMPLES + 1
    )  # distances from the vertex, divided by the height
    centre_fraction = float(np.trapezoid(z**3) / np.trapezoid(z**2))
    height = problem.body.com_distance / 0.75
    by_means = [period_by_means(motion) / motion.period - 1.0 for motion in (resting, turning)]
    return Record(
        centre=centre_fraction * height,  # [m] centre of the cone's mass, from the vertex
        momentum=problem.body.inertia_x
        * turning.theta_dot,  # [kg m^2/s] at the start of Fig. 3
        # [J] tops of the wells at ω = 26 rad/s
        wells=tuple(sorted(e.potential for e in problem.equilibria if e.kind == "saddle")),
        # [J] barriers of Fig. 3, of Fig. 3 with Y = 0, and of Fig. 3 at ω = 10 rad/s
        barriers=[double(other.motion.barriers[0]) for other in others],
        # numbers of angles that give the periods of Fig. 2 and Fig. 3 to PERIOD_TOLERANCE
        angles=(points_needed(resting), points_needed(turning)),
        # largest relative error of the periods by arithmetic-geometric means
        by_means=max(map(abs, by_means)),
        moments=_moments(turning),
        rotations=rotations(),
        times=_time_over_angle(resting, turning),
        vectors=triple_products(problem),
        maps=[period_map(problem, *axis) for axis in GRID_AXES],
        rates=SPEED_MAP_RATES,
        enough=PERIOD_TOLERANCE,
        scene=ROTATING,
    )


def _time_over_angle(resting: PendulumMotion, turning: PendulumMotion) -> Record:
    """Returns the numbers on eq. 16, the time as a function of the angle."""
    points = points_needed(resting)
    period = period_by_points(resting, points)
    theta = np.linspace(0.0, FULL_TURN, MAXIMUM_SAMPLES + 1)
    deviations = [m.time_at(theta) / m.period - theta / FULL_TURN for m in (resting, turning)]
    crossings = [np.diff(deviation[1:-1] > 0.0) for deviation in deviations]
    turns = (
        turning.time_at(np.array([FULL_TURN, 2 * FULL_TURN, 3 * FULL_TURN])) / turning.period
    )
    return Record(
        period=period,  # [s] of Fig. 2
        printed=2.0 * period,  # [s] period of Fig. 2 with the printed factor 2 I_x
        slope=_momentum_slope(resting, 1.0),  # [kg m^2] p ∂p/∂H by differences
        turns=list(turns),  # times of one, two and three turns, in periods
        # largest distance of t/T from θ/2π, in Figs. 2 b and 3 b
        off_line=[np.abs(deviation).max() for deviation in deviations],
        # number of crossings of t/T and θ/2π within a turn
        crossings=[int(np.count_nonzero(crossing)) for crossing in crossings],
        # rotation just above the barrier on a turning platform
        long=rotation_over_top(closed_forms(BARELY_OVER_BARRIER).correct),
    )


def _momentum_slope(motion: PendulumMotion, theta: float) -> float:
    """Returns p ∂p/∂H [kg m^2] of (15) at `theta` [rad]. Since p^2 is linear in H, a difference
    over any interval is exact."""
    energy = float(double(motion.energy))
    potential = float(in_double(motion.potential).value(theta))
    low = 2 * motion.inertia * (energy - potential)  # p^2 at the energy of the motion
    high = 2 * motion.inertia * (2 * energy - potential)  # p^2 at twice that energy
    return (high - low) / (2 * energy)


def triple_products(pendulum: ConePendulum) -> Record:
    """Returns the triple product M V · [Ω, R] of (4) at VECTORS, from its vectors, with R = S n_z1
    as written and with -R, and the right side of (4)."""
    theta, rate, x = VECTORS
    platform = np.array([0.0, 0.0, pendulum.platform_rate])
    turning = np.array([rate, 0.0, pendulum.platform_rate])
    pivot = np.cross(platform, [x, pendulum.pivot_y, pendulum.pivot_z])
    axis = np.array([0.0, -np.sin(theta), np.cos(theta)])  # n_z1
    arm = pendulum.body.com_distance * axis
    as_written = float(pendulum.body.mass * pivot @ np.cross(turning, arm))
    opposite = float(pendulum.body.mass * pivot @ np.cross(turning, -arm))
    formula = energies(replace(pendulum, pivot_x=x), np.array([theta]), np.array([rate]))
    return Record(
        theta=theta,
        theta_dot=rate,
        pivot_x=x,
        as_written=as_written,
        opposite=opposite,
        formula=formula.coupling[0],  # the right side of eq. (4) of the paper
    )


def period_by_means(motion: PendulumMotion) -> float:
    """Returns the period [s] of a rotation by one arithmetic-geometric mean, from the roots of P(u)
    with u = tan(theta/2). The period is a complete elliptic integral of the first kind."""
    v = in_double(motion.potential)
    energy = float(double(motion.energy))
    roots = np.roots([energy - v.c, 2 * v.b, 2 * energy + 4 * v.a, 2 * v.b, energy + v.c])
    first, second = roots[roots.imag > 0.0]
    p = abs(first - second.conjugate())
    q = abs(first - second)
    mean = p
    other = np.sqrt(p * p - q * q)
    while abs(mean - other) > 1e-15 * mean:
        mean, other = (mean + other) / 2, np.sqrt(mean * other)
    return float(np.sqrt(2 * motion.inertia / (energy - v.c)) * FULL_TURN / mean)


def period_by_points(motion: PendulumMotion, count: int) -> float:
    """Returns the period [s] of a rotation by eq. 16, summed over `count` equally spaced angles as
    in the source's worksheet."""
    theta = np.arange(count) * FULL_TURN / count
    return float(np.mean(motion.inertia / motion.momentum(theta)) * FULL_TURN)


def points_needed(motion: PendulumMotion) -> int:
    """Returns the smallest power of two for which `period_by_points` gives the period to the
    relative error PERIOD_TOLERANCE."""
    count = 4
    while abs(period_by_points(motion, count) / motion.period - 1.0) > PERIOD_TOLERANCE:
        count *= 2
    return count


def period_map(pendulum: ConePendulum, axis: str, values: Array) -> Record:
    """Returns a map of the periods of rotations that start at theta = 0, relative to the period of
    Fig. 3, as base-10 logarithms, shape (values, rates); NaN if the pendulum swings.

    One axis of the map is the platform's rate (SPEED_MAP_RATES). If `axis` is "S", the other axis
    is the distance of the centre of mass from the pivot [m], with unchanged moments about the
    centre of mass. If `axis` is "Y", the other axis is the pivot's y [m]."""
    body = pendulum.body
    squares = SPEED_MAP_RATES**2
    s: Array | float = body.com_distance
    y: Array | float = pendulum.pivot_y
    if axis == "S":
        s = values[:, None]
    else:
        y = values[:, None]
    # [kg m^2] change of the inertia by the parallel-axis theorem
    shifted = body.mass * (np.square(s) - body.com_distance**2) + 0 * squares
    flank = 0.5 * (body.inertia_y + shifted - body.inertia_z) * squares
    swing = body.mass * y * s * squares
    weight = body.mass * pendulum.gravity * s + 0 * squares
    periods = uniformity_from_bottom(
        TrigonometricPotential(flank, swing, weight),
        body.inertia_x + shifted,
        np.asarray(pendulum.theta_dot),
    ).period
    turning = np.isfinite(periods)
    edge = np.argwhere(turning[1:] != turning[:-1])
    middles = 0.5 * (values[1:] + values[:-1])
    return Record(
        axis=axis,
        places=values,  # [m]
        powers=np.log10(periods / pendulum.motion.period),
        rotating=turning.mean(),  # fraction of the map in which the pendulum rotates
        # boundary of rotation: platform rates, and the start values at the boundary
        edge=(SPEED_MAP_RATES[edge[:, 1]], middles[edge[:, 0]]),
        shortest=np.nanmin(periods),  # [s]
        longest=np.nanmax(periods),
    )


def _moments(motion: PendulumMotion) -> Record:
    """Returns the moments about the axis [N m] at ω = 26 rad/s, of gravity and of the platform's
    rotation, and their work [J]."""
    v = in_double(motion.potential)
    theta = np.linspace(0.0, FULL_TURN, 2 * MAXIMUM_SAMPLES + 1)
    gravity = -v.c * np.sin(theta)
    platform = -v.slope(theta) - gravity
    up = slice(MAXIMUM_SAMPLES + 1)
    work = round(float(np.trapezoid(platform[up], theta[up])), 9)
    return Record(
        gravity=np.abs(gravity).max(),  # [N m] largest magnitude
        # [π rad] angle at which the moment of gravity opposes the rotation most
        gravity_at=float(theta[np.argmin(gravity[up])]) / np.pi,
        gravity_at_top=abs(float(gravity[MAXIMUM_SAMPLES])),  # [N m]
        gravity_work=np.trapezoid(gravity[up], theta[up]),  # [J] from the bottom to the top
        platform=np.abs(platform).max(),  # [N m] largest magnitude
        platform_work=work + 0.0,  # [J] rounded to zero, without a negative sign
    )


def rotations() -> Mapping[str, Record]:
    """Returns the rotations of Fig. 2 ("resting") and Fig. 3 ("turning"), of Fig. 3 by the printed
    H ("printed"), and from the start of Fig. 3 on a platform at rest ("level")."""
    resting = closed_forms(RESTING)
    turning = closed_forms(ROTATING)
    motions = {
        "resting": resting.correct,
        "turning": turning.correct,
        "printed": turning.printed,
        "level": replace(turning.problem, platform_rate=0.0).motion,
    }
    return {name: rotation_over_top(motion) for name, motion in motions.items()}


def rotation_over_top(motion: PendulumMotion) -> Record:
    """Returns the energies and speeds of a rotation over the top."""
    phases = (np.arange(MAXIMUM_SAMPLES) + 0.5) / MAXIMUM_SAMPLES
    speed = motion.state(phases * motion.period)[1]
    rising = np.roll(speed, -1) > speed
    deviation = np.abs(speed / motion.theta_dot - 1.0)
    extremes = int(np.count_nonzero(rising != np.roll(rising, 1)))
    highest = float(speed.max())
    lowest_at = float(phases[speed.argmin()])
    at_half = extremes == 2 and abs(lowest_at - 0.5) < 1.0 / MAXIMUM_SAMPLES
    return Record(
        period=motion.period,  # [s]
        mean=FULL_TURN / motion.period,  # [rad/s] mean speed
        barrier=double(motion.barriers[0]),  # [J]
        energy=double(motion.energy),  # [J]
        start=motion.theta_dot,  # [rad/s] initial speed
        lowest=speed.min(),  # [rad/s]
        highest=highest,  # [rad/s]
        lowest_at=lowest_at,  # time of the lowest speed, as a fraction of the period
        extremes=extremes,  # number of extremes of the speed in a period
        # ratio of the speed's range in the second half of the period to the initial speed
        second_half=float(np.ptp(speed[MAXIMUM_SAMPLES // 2 :])) / motion.theta_dot,
        # fractions of the period during which the speed is within SPEED_DIFFERENCES of the initial
        # speed
        near=[(deviation <= near).mean() for near in SPEED_DIFFERENCES],
        spread=float(np.ptp(speed))
        / abs(motion.theta_dot),  # ratio of the range to the initial speed
        # whether the speed is largest at the start and has one minimum, at half the period
        slowest_at_half=at_half and highest <= motion.theta_dot,
    )


SOURCE_TEXT = Analysis("cone_pendulum/source_text", exact=numbers)
