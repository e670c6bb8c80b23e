"""The finding on plans run open-loop: how far off the pose ends, and where that arises."""

from __future__ import annotations

from functools import cache

import numpy as np

from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS
from plumbob.reports.findings.capsule_plan.plans import SHOWN, command, plan_of, scenes
from plumbob.reports.findings.plan_errors import PlanRun, arising, run_plan
from plumbob.reports.view.content import Figure, Finding, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic

DEFAULT = "mujoco/euler"
METHODS = ("mujoco/euler+coulomb", "pymunk/feet", "mujoco/rk4+coulomb", DEFAULT)
QUICK = METHODS[:2]
STEP = 1e-3  # [s]
KINDS = (("turn", "turns"), ("line", "lines"), ("slow", "slow motions"))
LEAST = 1e-12  # [m] and [rad]: where an error of zero is drawn


@cache
def ran(name: str, method: str) -> PlanRun | None:
    """A scene's plan run open-loop; None where the engine is missing or does not reach its end."""
    how = find_method(method)
    if not installed(engine_of(how)):
        return None
    found = run_plan(plan_of(name), find_scene(name), how, STEP)
    return found if found.found.status == "done" and found.after[-1] is not None else None


def finding(study: Study) -> Finding | None:
    """The pose's error at the end by plan and method, by the kind of manoeuvre that it is from;
    None without a plan or an engine."""
    chosen = [scene.name for scene in scenes(study)]
    methods = METHODS if study.profile == "full" else QUICK
    rows, ends, held = [], dict[str, list[float]](), dict[bool, list[float]]()
    for name in chosen:
        for method in methods:
            if (found := ran(name, method)) is None or (last := found.after[-1]) is None:
                continue
            parts = arising(plan_of(name), found)
            cells = [value(last.distance), value(last.heading)]
            for kind, _ in KINDS:
                part = parts.get(kind)
                cells += [value(None if part is None else part.distance, 2),
                          value(None if part is None else part.heading, 2)]  # fmt: skip
            ends.setdefault(method, []).append(last.distance)
            if "slow" in parts:
                held.setdefault(method == DEFAULT, []).append(parts["slow"].distance)
            rows.append(row(name.partition("/")[2], named(method), *cells))
    if not rows:
        return None
    heads = ("plan", "method", "off at the end [m]", "[rad]",
             *(head for _, kind in KINDS for head in (f"from {kind} [m]", "[rad]")))  # fmt: skip
    said = "; ".join(
        f"{name} {number(min(e), 2)}" + (f" to {number(max(e), 2)}" if len(e) > 1 else "")
        for name, e in ends.items()
    )
    return Finding(
        "capsule-plan-open-loop",
        "Run open-loop, a plan ends off by what its turns and lines added",
        "measured",
        f"With steps of {short(STEP)} s the place at the end is off by, in metres: {said}."
        f"{_slow(held)}",
        (
            "The engines are driven with the planned motion of the slider and nothing is measured "
            "on the way. What is off after a turn's residual motion, less what was off before, is "
            "that turn's; an error of the heading carries every line that follows aside, and "
            "counts there as the lines'.",
            "Turns bring the heading's error, with a "
            "semi-implicit Euler step most of all, for it leaks angular momentum; lines bring "
            "what is missed of a stop within a step, and the way aside.",
        ),
        (Table(f"Pose off at the end, and the manoeuvres that it is from, steps of {short(STEP)} s",
               heads, tuple(rows)),),
        (() if SHOWN not in chosen else tuple(_along(SHOWN, methods, which)
                                              for which in ("distance", "heading"))),
        tuple(command(chosen[0], method, short(STEP)) for method in QUICK),
    )  # fmt: skip


def _slow(held: dict[bool, list[float]]) -> str:
    """What slow motions add, on friction that converges and on default contacts."""
    said = ""
    if False in held:
        said += f" Slow motions add at most {number(max(held[False]), 2)} m"
    if True in held:
        said += f"; on default contacts, which creep, up to {number(max(held[True]), 2)} m"
    return f"{said}." if said else ""


def _along(name: str, methods: tuple[str, ...], which: str) -> Figure:
    """By how much the pose is off after each manoeuvre."""
    plan, traces = plan_of(name), list[Trace]()
    for method in methods:
        if (found := ran(name, method)) is None:
            continue
        known = [(end, abs(getattr(off, which)), one.kind)
                 for end, off, one in zip(plan.ends, found.after, plan.manoeuvres, strict=True)
                 if off is not None]  # fmt: skip
        times, sizes, kinds = zip(*known, strict=True)
        traces.append(
            curve(times, np.maximum(sizes, LEAST), colour=COLOURS[method], marks=True, width=1.0,
                  name=method, hints=[f"after a {kind}" for kind in kinds],
                  hint="%{text}, t = %{x:.3g} s: %{y:.3g}")
        )  # fmt: skip
    title, unit = ("Place", "m") if which == "distance" else ("Heading", "rad")
    return figure(
        f"{title} off after each manoeuvre of {name.partition('/')[2]}",
        f"Where the body is at rest, steps of {short(STEP)} s.",
        traces, linear("time [s]"), logarithmic(f"off by [{unit}]"), legend=True,
    )  # fmt: skip
