"""Further statements of the source on its motions, and what each is judged by."""

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
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.measurements import TURN, in_double

SAMPLES = 20_000  # over a period, or half a turn: a largest value is known to eight digits
NEAR = (0.05, 0.10)  # of the initial speed
HARDLY = "cone-pendulum/above-barrier-1e-6"  # rotates, with 1e-6 of the barrier to spare
VECTORS = (0.7, 5.0, 0.2)  # theta [rad], dθ/dt [rad/s] and X [m], at which (4) is worked out
RATES = np.linspace(0.0, 100.0, 41)  # [rad/s] of the platform
AXES = (("S", np.linspace(0.02, 0.3, 36)), ("Y", np.linspace(0.0, 0.35, 36)))  # [m]
ENOUGH = 1e-12  # relative, of a period by the trapezoid rule


def numbers(study: Study) -> Record:
    """Numbers that the statements are judged by, of the sources and the exact motions alone."""
    resting = forms(RESTING).correct
    turning = forms(ROTATING).correct
    problem = forms(ROTATING).problem
    others = (problem, replace(problem, pivot_y=0.0), replace(problem, platform_rate=10.0))
    z = np.linspace(0.0, 1.0, SAMPLES + 1)  # from the vertex, over the height
    slices = float(np.trapezoid(z**3) / np.trapezoid(z**2))
    return Record(
        centre=slices
        * problem.body.com_distance
        / 0.75,  # of the cone's mass, from the vertex [m]
        momentum=problem.body.inertia_x
        * turning.theta_dot,  # at the start of Fig. 3 [kg m^2/s]
        # tops [J] of the wells at ω = 26 rad/s
        wells=tuple(sorted(e.potential for e in problem.equilibria if e.kind == "saddle")),
        # [J], of Fig. 3, with Y = 0, and at ω = 10 rad/s
        barriers=[double(other.motion.barriers[0]) for other in others],
        # enough for the period of Fig. 2 and of Fig. 3
        angles=(
            points_needed(resting),
            points_needed(turning),
        ),
        # largest error of the periods by means, relative
        by_means=max(abs(period_by_means(m) / m.period - 1.0) for m in (resting, turning)),
        moments=_moments(turning),
        rotations=rotations(),
        times=_times(resting, turning),
        vectors=vectors(problem),
        maps=[over_rates(problem, *axis) for axis in AXES],
        rates=RATES,
        enough=ENOUGH,
        scene=ROTATING,
    )


def _times(resting: PendulumMotion, turning: PendulumMotion) -> Record:
    """The time over the angle, eq. 16."""
    points = points_needed(resting)
    period = period_by_points(resting, points)
    theta = np.linspace(0.0, TURN, SAMPLES + 1)
    off = [m.time_at(theta) / m.period - theta / TURN for m in (resting, turning)]
    turns = turning.time_at(np.array([TURN, 2 * TURN, 3 * TURN])) / turning.period
    return Record(
        period=period,  # [s], of Fig. 2
        printed=2.0 * period,  # the same with the factor 2 I_x of the print [s]
        slope=_momentum_slope(resting, 1.0),  # p ∂p/∂H [kg m^2], by differences
        turns=[one for one in turns],  # t at one, two and three turns, in periods
        # largest distance of t/T from θ/2π, in Figs. 2 b and 3 b
        off_line=[np.abs(one).max() for one in off],
        # how often t/T crosses θ/2π within a turn
        crossings=[int(np.count_nonzero(np.diff(one[1:-1] > 0.0))) for one in off],
        long=rotation(forms(HARDLY).correct),  # hardly above the barrier, on a turning platform
    )


def _momentum_slope(motion: PendulumMotion, theta: float) -> float:
    """p ∂p/∂H [kg m^2] of (15) at `theta` [rad]: p^2 is linear in H, so any difference will do."""
    energy = float(double(motion.energy))
    v = in_double(motion.potential)
    low, high = (2 * motion.inertia * (e - float(v.value(theta))) for e in (energy, 2 * energy))
    return (high - low) / (2 * energy)


def vectors(pendulum: ConePendulum) -> Record:
    """M V · [Ω, R] of (4) by its vectors at VECTORS, with R = S n_z1 as written, and with -R."""
    theta, rate, x = VECTORS
    platform = np.array([0.0, 0.0, pendulum.platform_rate])
    turning = np.array([rate, 0.0, pendulum.platform_rate])
    pivot = np.cross(platform, [x, pendulum.pivot_y, pendulum.pivot_z])
    axis = np.array([0.0, -np.sin(theta), np.cos(theta)])  # n_z1
    arm = pendulum.body.com_distance * axis
    as_written, opposite = (
        float(pendulum.body.mass * pivot @ np.cross(turning, place)) for place in (arm, -arm)
    )
    formula = energies(replace(pendulum, pivot_x=x), np.array([theta]), np.array([rate]))
    return Record(
        theta=theta,
        theta_dot=rate,
        pivot_x=x,
        as_written=as_written,
        opposite=opposite,
        formula=formula.coupling[0],  # the right side of (4)
    )


def period_by_means(motion: PendulumMotion) -> float:
    """Period [s] of a rotation by one arithmetic-geometric mean, from the roots of P(u) with
    u = tan(theta/2): a complete elliptic integral of the first kind, and nothing else."""
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
    return float(np.sqrt(2 * motion.inertia / (energy - v.c)) * TURN / mean)


def period_by_points(motion: PendulumMotion, count: int) -> float:
    """Period [s] of a rotation by eq. 16 summed over `count` angles spread evenly, as the source's
    worksheet has them."""
    theta = np.arange(count) * TURN / count
    return float(np.mean(motion.inertia / motion.momentum(theta)) * TURN)


def points_needed(motion: PendulumMotion) -> int:
    """The least power of two of points at which that sum is the period to ENOUGH."""
    count = 4
    while abs(period_by_points(motion, count) / motion.period - 1.0) > ENOUGH:
        count *= 2
    return count


def over_rates(pendulum: ConePendulum, axis: str, values: Array) -> Record:
    """The period from theta = 0 over that of Fig. 3, as a power of ten, shape (values,
    rates): by the distance S [m] of the centre of mass, about which the body stays the same, or by
    the pivot's Y [m]; NaN where it swings."""
    body = pendulum.body
    squares = RATES**2
    usual = body.com_distance, pendulum.pivot_y
    s, y = (values[:, None], usual[1]) if axis == "S" else (usual[0], values[:, None])
    shifted = body.mass * (np.square(s) - usual[0] ** 2) + 0 * squares  # Steiner
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
    return Record(
        axis=axis,
        places=values,  # [m]
        powers=np.log10(periods / pendulum.motion.period),
        rotating=turning.mean(),  # part of the map
        edge=(RATES[edge[:, 1]], (0.5 * (values[1:] + values[:-1]))[edge[:, 0]]),
        shortest=np.nanmin(periods),  # [s]
        longest=np.nanmax(periods),
    )


def _moments(motion: PendulumMotion) -> Record:
    """Moments about the axis [N m] at ω = 26 rad/s: gravity's, and that of the rotation."""
    v = in_double(motion.potential)
    theta = np.linspace(0.0, TURN, 2 * SAMPLES + 1)
    gravity = -v.c * np.sin(theta)
    platform = -v.slope(theta) - gravity
    up = slice(SAMPLES + 1)
    work = round(float(np.trapezoid(platform[up], theta[up])), 9)
    return Record(
        gravity=np.abs(gravity).max(),  # the largest
        # where that opposes the rotation [π]
        gravity_at=float(theta[np.argmin(gravity[up])]) / np.pi,
        gravity_at_top=abs(float(gravity[SAMPLES])),
        gravity_work=np.trapezoid(gravity[up], theta[up]),  # [J], from the bottom to the top
        platform=np.abs(platform).max(),  # the largest
        platform_work=work + 0.0,  # without what rounding leaves, its sign included
    )


def rotations() -> Mapping[str, Record]:
    """Those of Figs. 2 and 3, of the latter by the printed H, and from its start on a platform at
    rest."""
    resting = forms(RESTING)
    turning = forms(ROTATING)
    motions = {
        "resting": resting.correct,
        "turning": turning.correct,
        "printed": turning.printed,
        "level": replace(turning.problem, platform_rate=0.0).motion,
    }
    return {name: rotation(motion) for name, motion in motions.items()}


def rotation(motion: PendulumMotion) -> Record:
    """The energies and speeds of a motion over the top."""
    phases = (np.arange(SAMPLES) + 0.5) / SAMPLES
    speed = motion.state(phases * motion.period)[1]
    rising = np.roll(speed, -1) > speed
    deviation = np.abs(speed / motion.theta_dot - 1.0)
    extremes = int(np.count_nonzero(rising != np.roll(rising, 1)))
    highest = float(speed.max())
    lowest_at = float(phases[speed.argmin()])
    at_half = extremes == 2 and abs(lowest_at - 0.5) < 1.0 / SAMPLES
    return Record(
        period=motion.period,  # [s]
        mean=TURN / motion.period,  # speed [rad/s]
        barrier=double(motion.barriers[0]),  # [J]
        energy=double(motion.energy),  # [J]
        start=motion.theta_dot,  # speed [rad/s]
        lowest=speed.min(),
        highest=highest,
        lowest_at=lowest_at,  # fraction of the period
        extremes=extremes,  # of the speed
        # range of the speed in the second half of the period, over the start's
        second_half=float(np.ptp(speed[SAMPLES // 2 :])) / motion.theta_dot,
        # fractions of the period within each of NEAR of the start's
        near=[(deviation <= near).mean() for near in NEAR],
        spread=float(np.ptp(speed)) / abs(motion.theta_dot),  # over the initial speed
        # the speed is largest at the start, and has one minimum, at half the period
        slowest_at_half=at_half and highest <= motion.theta_dot,
    )


SOURCE_TEXT = Analysis("cone_pendulum/source_text", numbers)
