"""Further statements of the source on its motions, each computed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.measurements import largest
from plumbob.reports.view.content import Finding, Statement
from plumbob.reports.view.notation import number
from plumbob.reports.view.sources import SUDAKOV, stated

SAMPLES = 20_000  # over a period or a turn
ENOUGH = 1e-12  # relative, of a period by the trapezoid rule


def turned_by(problem: ConePendulum, theta: Array) -> tuple[Array, Array]:
    """Moments [N m] about the axis, shape (n,): gravity's, and that of the platform's rotation."""
    v = problem.motion.potential
    a, b, c = (float(double(x)) for x in (v.a, v.b, v.c))
    return -c * np.sin(theta), 2 * a * np.sin(theta) * np.cos(theta) + b * np.cos(theta)


def period_by_means(motion: PendulumMotion) -> float:
    """Period [s] of a rotation by one arithmetic-geometric mean, from the roots of P(u) with
    u = tan(theta/2): a complete elliptic integral of the first kind, and nothing else."""
    v, inertia = motion.potential, motion.inertia
    a, b, c, energy = (float(double(x)) for x in (v.a, v.b, v.c, motion.energy))
    roots = np.roots([energy - c, 2 * b, 2 * energy + 4 * a, 2 * b, energy + c])
    first, second = roots[roots.imag > 0.0]
    p, q = abs(first - second.conjugate()), abs(first - second)
    mean, other = p, np.sqrt(p * p - q * q)
    while abs(mean - other) > 1e-15 * mean:
        mean, other = (mean + other) / 2, np.sqrt(mean * other)
    return float(np.sqrt(2 * inertia / (energy - c)) * 2 * np.pi / mean)


def period_by_points(motion: PendulumMotion, count: int) -> float:
    """Period [s] of a rotation by eq. 16 summed over `count` angles spread evenly, as the source's
    worksheet has them."""
    theta = np.arange(count) * 2 * np.pi / count
    return float(np.mean(motion.inertia / motion.momentum(theta)) * 2 * np.pi)


def points_needed(motion: PendulumMotion) -> int:
    """The least power of two of points at which that sum is the period to ENOUGH."""
    count = 4
    while abs(period_by_points(motion, count) / motion.period - 1.0) > ENOUGH:
        count *= 2
    return count


def extremes(motion: PendulumMotion) -> tuple[Array, Array]:
    """Times over the period, and speeds [rad/s], at which the speed of a rotation is an extreme:
    that of the start among them where it is one."""
    phases = np.arange(SAMPLES) / SAMPLES
    speed = motion.state(phases * motion.period)[1]
    rising = np.roll(speed, -1) > speed
    kept = rising != np.roll(rising, 1)
    return phases[kept], speed[kept]


def halves(motion: PendulumMotion) -> tuple[float, float]:
    """Range of the speed over the initial speed in either half of a period."""
    speed = motion.state((np.arange(SAMPLES) + 0.5) * motion.period / SAMPLES)[1]
    first, second = np.split(speed / motion.theta_dot, 2)
    return float(np.ptp(first)), float(np.ptp(second))


def finding(study: Study) -> Finding:
    """The statements as a table; all of them are rows of the table of the sources too."""
    statements = (*_of_the_body(), *_of_the_integrals(), *_of_the_figures())
    corrected = sum(statement.verdict in ("corrected", "refuted") for statement in statements)
    return Finding(
        "source-text",
        "What else the source says of its motions, statement by statement",
        "mostly right",
        f"{len(statements) - corrected} of {len(statements)} statements hold, or more than they "
        f"say does; {corrected} do not.",
        (
            "Gravity's moment is –MgS sin θ: zero at the top, where the source has it the largest. "
            "The speed is the smallest there because gravity has opposed the rotation all the way "
            "up. The moment of the platform's rotation comes from a potential that is the same at "
            "θ = 0 and at θ = π: over half a turn it does no work, so that it compensates gravity "
            "at some angles and adds to it at others.",
        ),
        (stated(statements),),
        (),
        (f"plumbob solve {ROTATING} --angles 0,1.5708,3.1416,4.7124,6.2832",
         f"plumbob solve {ROTATING} --set platform_rate=10 --figures figures.html"),
        statements,
    )  # fmt: skip


def _of_the_body() -> tuple[Statement, ...]:
    problem, start = forms(ROTATING).problem, forms(ROTATING).correct
    body = problem.body
    z = np.linspace(0.0, 1.0, SAMPLES + 1)  # from the vertex, over the height
    centre = np.trapezoid(z**3) / np.trapezoid(z**2) * body.com_distance / 0.75
    turn = np.linspace(0.0, 2 * np.pi, SAMPLES + 1)
    moments = [lambda theta, k=k: turned_by(problem, theta)[k] for k in (0, 1)]
    wells = sorted(e.potential for e in problem.equilibria if e.kind == "saddle")
    momentum = body.inertia_x * start.theta_dot
    return (
        Statement(SUDAKOV, "(1)", "The centre of mass is ¾ H from the vertex", "S = ¾H",
                  f"{centre:.6f} m, by summing over slices", "holds"),
        Statement(SUDAKOV, "introduction",
                  "Inertia forces add a moment that depends on ω and on the angle", "no value",
                  f"up to {number(largest(moments[1], turn), 4)} N m at ω = 26 rad/s; gravity's "
                  f"is up to {number(largest(moments[0], turn), 4)} N m", "holds"),
        Statement(SUDAKOV, "introduction",
                  "The initial energy decides between swinging and rotating", "no value",
                  f"at ω = 26 rad/s: in one of two wells below {wells[0]:.3f} J, over both below "
                  f"{wells[1]:.3f} J, rotating above", "holds"),
        Statement(SUDAKOV, "(8)", "The momentum is p = I_x dθ/dt", "I_x dθ/dt",
                  f"{momentum:.4f} kg m²/s at the start of Fig. 3; for a pivot at X ≠ 0, (6) gives "
                  "MXSω cos θ more, a total derivative without effect", "holds"),
    )  # fmt: skip


def _of_the_integrals() -> tuple[Statement, ...]:
    resting, turning = forms(RESTING).correct, forms(ROTATING).correct
    both = [abs(period_by_means(m) / m.period - 1.0) for m in (resting, turning)]
    needed = [points_needed(m) for m in (resting, turning)]
    moved = (
        replace(forms(ROTATING).problem, pivot_y=0.0),
        replace(forms(ROTATING).problem, platform_rate=10.0),
    )
    tops = [float(double(p.motion.barriers[0])) for p in (forms(ROTATING).problem, *moved)]
    return (
        Statement(SUDAKOV, "(16)",
                  "The time is a sum over angles spread evenly, without branches",
                  "arrays in MathCAD",
                  f"{needed[0]} angles give the period to {number(ENOUGH, 1)} on the platform at "
                  f"rest, {needed[1]} on the turning one", "holds"),
        Statement(SUDAKOV, "conclusion",
                  "The integral is elliptic on a platform at rest, and not on a turning one",
                  "elliptic at rest only",
                  "of the first kind on both: periods from one arithmetic-geometric mean within "
                  f"{number(max(both), 1)}, relative", "refuted"),
        Statement(SUDAKOV, "conclusion",
                  "The method shows what ω, the pivot or the pendulum's mass properties change",
                  "no value",
                  f"for any parameters, in closed form: the barrier of {tops[0]:.3f} J is "
                  f"{tops[1]:.3f} J with Y = 0 and {tops[2]:.3f} J at ω = 10 rad/s", "extended"),
    )  # fmt: skip


def _of_the_figures() -> tuple[Statement, ...]:
    resting, turning, printed = (
        forms(RESTING).correct, forms(ROTATING).correct, forms(ROTATING).printed,
    )  # fmt: skip
    level = replace(forms(ROTATING).problem, platform_rate=0.0).motion
    when, speed = extremes(resting)
    slowest = int(np.argmin(speed))
    theta = np.linspace(0.0, np.pi, SAMPLES + 1)
    against = -turned_by(forms(RESTING).problem, theta)[0]
    _, platform = turned_by(forms(ROTATING).problem, theta)
    work = round(float(np.trapezoid(platform, theta)), 9) + 0.0  # without what rounding leaves
    up = -float(np.trapezoid(against, theta))
    turns = [len(extremes(m)[0]) for m in (resting, turning, printed)]
    second = [halves(m)[1] for m in (turning, level, printed, resting)]
    rates = [2 * np.pi / m.period for m in (turning, printed, resting)]
    first_only = slowest == 1 and len(when) == 2 and abs(when[slowest] - 0.5) < 1.0 / SAMPLES
    return (
        Statement(SUDAKOV, "Fig. 2 e",
                  "The speed has its maximum at the start and one minimum, at half of the period",
                  "at θ = π", f"{number(float(speed[slowest]), 5)} rad/s at {when[slowest]:.3f} T "
                  f"after {number(float(speed[0]), 5)} rad/s",
                  "holds" if first_only else "refuted"),
        Statement(SUDAKOV, "Fig. 2 e", "At θ = π gravity's moment opposes the rotation most",
                  "at θ = π", f"it is {number(abs(float(against[-1])), 1)} N m there; the largest, "
                  f"{number(float(against.max()), 4)} N m, is at "
                  f"θ = {number(float(theta[np.argmax(against)]) / np.pi, 3)} π",
                  "holds" if np.argmax(against) == SAMPLES else "refuted"),
        Statement(SUDAKOV, "Fig. 3 b", "The mean speed of rotation changes on the turning base",
                  f"{number(rates[1], 5)} rad/s by the printed H",
                  f"{number(rates[0], 5)} rad/s ({number(rates[2], 5)} rad/s at rest, from "
                  f"{number(resting.theta_dot)} rad/s)", "corrected"),
        Statement(SUDAKOV, "Fig. 3 c", "The phase curve differs in kind from that of Fig. 2",
                  "no value", f"{turns[1]} extremes of the speed in a period, {turns[0]} at rest",
                  "holds" if turns[1] != turns[0] else "refuted"),
        Statement(SUDAKOV, "Fig. 3 e",
                  "In the second half of the period the speed changes less than without inertia "
                  "forces", f"by {_percent(second[2])} by the printed H, against "
                  f"{_percent(second[3])} in Fig. 2",
                  f"by {_percent(second[0])}; at rest from the same speed {_percent(second[1])}",
                  "holds" if second[0] < second[3] else "refuted",
                  "" if second[0] < second[1] else "against Fig. 2, which starts at another speed"),
        Statement(SUDAKOV, "Fig. 3 e",
                  "The platform's rotation can to some degree compensate gravity's moment",
                  "to some degree",
                  f"at some angles: from θ = 0 to π its moment does {number(work, 1)} J of work in "
                  f"all, gravity's {number(up, 4)} J", "corrected"),
    )  # fmt: skip


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %"
