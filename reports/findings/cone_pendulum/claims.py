"""The source's claims about rotation on a turning base, each held against the exact motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.reports.findings.cone_pendulum.problems import RESTING, ROTATING, case
from plumbob.reports.view.content import Cell, Finding, Table
from plumbob.reports.view.notation import number

NEAR = (0.05, 0.10)  # of the initial speed
SAMPLES = 20_000  # over a period: shares of it to four digits


@dataclass(frozen=True)
class Speeds:
    """How even a rotation is: its speeds over one period, against the initial one."""

    least: float  # [rad/s]
    most: float
    spread: float  # over the initial speed
    near: tuple[float, ...]  # shares of the period within each of NEAR of the initial speed


def speeds(motion: PendulumMotion) -> Speeds:
    """Speeds of a rotation over one period."""
    times = (np.arange(SAMPLES) + 0.5) * motion.period / SAMPLES
    rate = motion.state(times)[1]
    off = np.abs(rate / motion.theta_dot - 1.0)
    return Speeds(
        float(rate.min()),
        float(rate.max()),
        float(np.ptp(rate) / abs(motion.theta_dot)),
        tuple(float((off <= share).mean()) for share in NEAR),
    )


def finding() -> Finding:
    """Each claim with what the printed formulas give, what is right, and a judgement."""
    resting, turning = case(RESTING).problem, case(ROTATING).problem
    same_start = replace(turning, platform_rate=0.0)
    at_rest, right = speeds(resting.motion), speeds(turning.motion)
    printed, level = speeds(case(ROTATING).printed), speeds(same_start.motion)
    barrier = float(double(turning.motion.barriers[0]))
    barrier_at_rest = float(double(resting.motion.barriers[0]))
    deepest = min(e.potential for e in turning.equilibria)
    top, _ = turning.printed_barrier
    speed, slow = number(turning.theta_dot), number(resting.theta_dot)
    rows = (
        _texts(
            "The energy needed to rotate rises to 514.197 J on the turning base",
            f"{top:.3f} J, the top of the printed V",
            f"{barrier:.3f} J ({barrier_at_rest:.3f} J at rest)",
            _judged(
                "wrong",
                f"The correct V is {deepest:.1f} J at its lowest: the printed figure is the depth "
                f"of the deepest well, its sign lost.",
            ),
        ),
        _texts(
            "A turning base makes the rotation more uniform",
            f"speed spread {_share(printed.spread)} of the initial {speed} rad/s, against "
            f"{_share(at_rest.spread)} of {slow} rad/s at rest",
            f"{_share(right.spread)} ({number(right.least, 4)} to {number(right.most, 4)} rad/s); "
            f"a resting base from the same {speed} rad/s: {_share(level.spread)}",
            _judged(
                "not shown",
                "The comparison changes the initial speed along with the base. From the same speed "
                "the turning base is the less uniform one.",
            )
            if level.spread < right.spread
            else _judged("right", "Also from the same initial speed."),
        ),
        _texts(
            "For half of the period the speed stays near its initial value",
            _shares(printed),
            _shares(right),
            _judged(
                "right, by luck" if printed.near[0] < 0.4 <= right.near[0] else "see figures",
                "The correct motion keeps the claim better than the printed one it was read off.",
            ),
        ),
        _texts(
            "Turning over is called libration, swinging vibration; θ = π the lower point",
            "–",
            "–",
            _judged(
                "words",
                "Rotation is rotation and libration is swinging here; θ = 0 hangs down, and the "
                "slowest point of Fig. 2, θ = π, is the upper one.",
            ),
        ),
    )
    heads = ("claim", "by the printed formulas", "correct", "judgement")
    return Finding(
        "claims",
        "The source's claims about the turning base, judged",
        "mostly wrong",
        f"The barrier is {barrier:.3f} J, not 514.197 J. From the same initial speed the turning "
        f"base makes the rotation less uniform ({_share(right.spread)} against "
        f"{_share(level.spread)} of spread), not more.",
        (),
        (Table("Claim by claim", heads, rows),),
        (),
        (
            f"plumbob solve {ROTATING}",
            f"plumbob solve {RESTING}",
            f"plumbob solve {ROTATING} --set platform_rate=0",
        ),
    )


def _texts(*texts: str) -> tuple[Cell, ...]:
    return tuple(Cell(text, "text") for text in texts)


def _judged(word: str, why: str) -> str:
    return f"{word}: {why}"


def _share(value: float) -> str:
    return f"{100 * value:.0f} %"


def _shares(found: Speeds) -> str:
    each = (
        f"{_share(part)} of the period within {_share(share)}"
        for part, share in zip(found.near, NEAR, strict=True)
    )
    return ", ".join(each)
