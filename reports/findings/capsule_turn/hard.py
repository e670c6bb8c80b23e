"""What a hard case of the turn shows beside the rest: modes, numbers, every method's end."""

from __future__ import annotations

import math

from plumbob.analytic.systems.capsule import lowest_normal_forces
from plumbob.engines.study.study import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import problem
from plumbob.reports.findings.capsule_turn.modes import figures
from plumbob.reports.view.content import Cell, Figure, Table, row
from plumbob.reports.view.notation import number, short


def hard(study: Study, scene: Scene) -> tuple[Figure | Table, ...]:
    """The exact motion's modes and slips, what makes the case hard in numbers, and each method's
    error at the end."""
    train = problem(scene.name).motion
    one = train.manoeuvre
    least, _ = lowest_normal_forces(one.capsule, one.track)
    about = (
        ("ε", one.epsilon),
        ("Zτ² [rad]", one.slider_angle),
        ("turns", float(train.count)),
        ("least Nᵢ over (M+m) g", float(min(least)) / one.capsule.weight),
        ("largest a Ω² [m/s²]", one.radius * (one.angular_acceleration * one.half_time) ** 2),
        ("at rest from [τ]", train.single.rest_time / one.half_time),
        ("body angle at the end [rad]", float(train.at(scene.duration).heading[0])),
    )
    numbers = Table(
        "What makes it hard", tuple(name for name, _ in about),
        (row(*(value(size, 6) for _, size in about)),),
        "" if train.count == 1 else "The modes are those of the first turn; all are alike.",
    )  # fmt: skip
    return (*figures(train.single, one.half_time), numbers, *_events(scene), *_ends(study, scene))


def _events(scene: Scene) -> tuple[Table, ...]:
    train = problem(scene.name).motion
    tau = train.manoeuvre.half_time
    last = train.single.rest_time
    following = [*(event.time for event in train.single.events[1:]), math.inf]
    rows = [
        row(value(event.time / tau, 6), event.mode,
            f"A{event.support + 1}" if event.support >= 0 else "",
            value((end - event.time) / tau if event.time < last else None, 4))
        for event, end in zip(train.single.events, following, strict=True)
    ]  # fmt: skip
    heads = ("from [τ]", "mode", "support at rest, or slipping from it", "lasts [τ]")
    return (Table("Events of the exact motion", heads, tuple(rows), folded=True),)


def _ends(study: Study, scene: Scene) -> tuple[Table, ...]:
    rows = []
    for convergence_study in study.convergence:
        if convergence_study.scene != scene.name:
            continue
        done = [m for m in convergence_study.measurements if m.status == "done"]
        if not done:
            why = convergence_study.measurements[-1] if convergence_study.measurements else None
            if why is not None and why.status == "diverged":
                rows.append(row(method_cell(convergence_study.method), value(why.step),
                                Cell(why.reason, span=4)))  # fmt: skip
            continue
        coarse, fine = done[0], done[-1]
        error = fine.errors["body_angle"]
        told = error.predicted.end if error.predicted else None
        order = None if convergence_study.order is None else convergence_study.order.slope
        rows.append(
            row(method_cell(convergence_study.method), Cell(short(fine.step), "number"),
                value(coarse.errors["body_angle"].end), value(error.end), value(told),
                value(order))
        )  # fmt: skip
    if not rows:
        return ()
    heads = ("method", "finest step [s]", "error at the coarsest [rad]", "at the finest [rad]",
             "predicted [rad]", "order")  # fmt: skip
    note = f"Over {number(scene.duration)} s. The order is that of the largest error on the way."
    return (Table("Body angle at the end", heads, tuple(rows), note),)
