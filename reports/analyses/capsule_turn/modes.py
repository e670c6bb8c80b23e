"""Modes of an exact turn: which support slides, is a pivot or rests, and what makes a case hard."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import problem

POINTS = 150  # of a curve of speeds, and more beside every event
DRAWN = 290  # points of a curve: more would be thinned
NEAR = 1e-12  # of the largest slip speed: where a support at rest is drawn
LATE = 1.08  # of the time to rest
Slips = tuple[Array, Array]  # times in half times; slip speeds over the largest, shape (3, n)


def modes_of(motion: ThreePointMotion, unit: float) -> Record:
    """Modes and slip speeds of a turn whose half time is `unit` [s]."""
    ends = [*(event.time for event in motion.events[1:]), LATE * motion.rest_time]
    modes = ["", *(event.mode for event in motion.events[:-1])]
    stays = tuple(
        Record(
            mode=event.mode,
            support=event.support + 1,  # 1, 2, 3: the pivot, or what has just slipped; 0: none
            begin=event.time / unit,
            end=end / unit,
            # None: for ever
            lasts=(end - event.time) / unit if event.time < motion.rest_time else None,
            # slides after sliding: a support stops and slides on at once
            again=before == event.mode == "slide",
        )
        for before, event, end in zip(modes, motion.events, ends, strict=True)
    )
    slips, top = _slips(motion, unit)
    # slip speeds in parts that join, and the largest [m/s]
    return Record(stays=stays, slips=slips, top=top)


def slip_speeds(motion: ThreePointMotion, times: Array) -> Array:
    """|v_i| [m/s] of each support, shape (3, n), at `times` [s], shape (n,)."""
    pose = motion.at(times)
    velocity = (pose.velocity @ [1.0, 1j]) * np.exp(-1j * pose.heading)
    supports = np.asarray(motion.capsule.supports) @ [1.0, 1j]
    return np.asarray(np.abs(velocity + 1j * pose.angular_velocity * supports[:, None]))


def _slips(motion: ThreePointMotion, unit: float) -> tuple[tuple[Slips, ...], float]:
    """Slip speeds of all supports, and the largest [m/s]."""
    end = LATE * motion.rest_time
    beside = np.geomspace(1e-9, 1e-2, 22) * end
    marks = [event.time + side for event in motion.events for side in (*-beside, 0.0, *beside)]
    even = np.linspace(0.0, end, POINTS)
    times = np.unique(np.clip([*even, *marks], 0.0, end))
    speeds = slip_speeds(motion, times)
    top = float(speeds.max()) or 1.0
    shown = np.maximum(speeds / top, NEAR)
    parts = np.array_split(np.arange(times.size), -(-times.size // DRAWN))
    reaches = [slice(part[0], part[-1] + 2) for part in parts]
    return tuple((times[reach] / unit, shown[:, reach]) for reach in reaches), top


def hard_turn(study: Study, scene: Scene) -> Record:
    """The exact motion's modes and slips, what makes the case hard, and errors at the end."""
    turned = problem(scene.name).motion
    move = turned.manoeuvre
    lowest, _ = lowest_normal_forces(move.capsule, move.track)
    endings = (_ending(series) for series in study.convergence if series.scene == scene.name)
    return Record(
        epsilon=move.epsilon,
        slider_angle=move.slider_angle,  # Z tau^2 [rad]
        count=turned.count,  # of turns
        # the smallest normal force, over the weight
        lightest=float(min(lowest)) / move.capsule.weight,
        # the largest a Omega^2 [m/s²]
        acceleration=move.radius * (move.angular_acceleration * move.half_time) ** 2,
        rest_at=turned.single.rest_time / move.half_time,  # in half times
        body_angle=turned.at(scene.duration).heading[0],  # at the end [rad]
        duration=scene.duration,  # [s]
        modes=modes_of(turned.single, move.half_time),
        endings=tuple(filter(None, endings)),
    )


def _ending(series: ConvergenceStudy) -> Record | None:
    """Errors of a method's body angle at the end [rad], at its coarsest and its finest step."""
    done = [run for run in series.measurements if run.status == "done"]
    if done:
        coarse, fine = (run.errors["body_angle"] for run in (done[0], done[-1]))
        predicted = fine.predicted.end if fine.predicted else None
        order = series.order.slope if series.order else None
        return Record(
            method=series.method,
            step=done[-1].step,  # the finest [s]
            lost="",  # why no run reached the end
            coarse=coarse.end,
            fine=fine.end,
            predicted=predicted,  # of the finest
            order=order,
        )
    for run in series.measurements[-1:]:
        if run.status == "diverged":
            return Record(
                method=series.method,
                step=run.step,
                lost=run.reason,
                coarse=None,
                fine=None,
                predicted=None,
                order=None,
            )
    return None


HARD = Analysis("capsule_turn/hard", hard_turn)
