"""How errors grow next to a saddle of the potential, whatever their cause."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.convergence import Trace as ErrorsOverTime
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Record

NEAR = 0.25  # [rad] from the saddle, where the motion is linear in the distance to 3 %
LINEAR = 0.1  # [rad]: an error larger than this no longer grows as e^(lambda t)
FEW = 4  # samples that a rate is not fitted to


def growth_at_saddle(
    study: Study, scene: Scene, motion: PendulumMotion, saddle: Record
) -> Record | None:
    """Errors of the study's runs of a scene over time, and the rates they grow at while its exact
    `motion` is next to the saddle; None where it never is."""
    traces = {
        c.method: c.trace
        for c in study.convergence
        if c.scene == scene.name and c.trace and any(c.trace.errors)
    }
    within = _first_stay(motion, saddle, np.linspace(0.0, scene.duration, 2001))
    if within is None or not traces:
        return None
    start, end = within
    times, stay = np.linspace(0.0, scene.duration, 200)[1:], np.linspace(start, end, 20)
    rounding = motion.uncertainty(times)["theta"]
    growth = np.interp(start, times, rounding) * np.exp(saddle.rate * (stay - start))
    return Record(
        rate=saddle.rate,  # [1/s], at which a motion departs from it
        start=start,  # [s], of the stay
        end=end,
        runs=[_grown(method, trace, start, end) for method, trace in traces.items()],
        methods=[method.name for method in study.methods],  # of the study
        times=times,  # [s]
        rounding=rounding,  # [rad], the effect of one rounding of each input, at them
        stay=stay,  # times [s] of the stay
        growth=growth,  # [rad], exponential, at them
        near=NEAR,
        linear=LINEAR,
    )


def _grown(method: str, trace: ErrorsOverTime, start: float, end: float) -> Record:
    """A run with its rate, fitted over the second half of the stay from `start` to `end`, where the
    growing mode dominates, while the error is small."""
    times, errors = np.array(trace.times), np.abs(trace.errors)
    large = times[errors >= LINEAR]
    until = min(end, float(large[0])) if large.size else end
    small = (errors < LINEAR) & (errors > 0.0)
    used = small & (times >= (start + until) / 2) & (times < until)
    slope = np.polyfit(times[used], np.log(errors[used]), 1)[0] if used.sum() > FEW else None
    lost = float(large[0]) if large.size else None
    return Record(
        method=method,
        times=trace.times[1:],
        errors=trace.errors[1:],
        rate=slope,  # [1/s], fitted next to the saddle; None with too few samples
        small_until=lost,  # [s]: the first larger than LINEAR
    )


def _first_stay(motion: PendulumMotion, saddle: Record, times: Array) -> tuple[float, float] | None:
    """When the exact motion first comes within NEAR of the saddle, and when it leaves."""
    theta = motion.state(times)[0]
    distance = np.abs((theta - saddle.theta + np.pi) % (2 * np.pi) - np.pi)
    inside = np.flatnonzero(distance < NEAR)
    if not inside.size:
        return None
    ends = np.flatnonzero(np.diff(inside) > 1)
    last = inside[ends[0]] if ends.size else inside[-1]
    return float(times[inside[0]]), float(times[last])
