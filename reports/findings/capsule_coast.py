"""The page's section on the capsule coasting to rest: what a step does to a stop and to a spin."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.study import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS, covers, measured, problem, run
from plumbob.reports.view.content import Cell, Figure, Finding, Section, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, logarithmic, positive

SCENE = "capsule-coast/translation"
METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/feet",
           "pymunk/side")  # fmt: skip
STEPS = (1e-3, 1e-4)
SPIN = "capsule-coast/spin"
DEFAULT = "mujoco/euler"
SPINNING = ("mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet", DEFAULT)
DECADE = (1e-3, 5e-4, 2e-4, 1e-4)


def findings(study: Study) -> Sequence[Finding]:
    """What the step does to the stopping distance, and to a spin with translation."""
    return (*_stopping(), *_spin(study))


def _stopping() -> Sequence[Finding]:
    """Error of the stopping distance over v0 dt/2, in both engines."""
    posed = problem(SCENE)
    theory = case_of(find_scene(SCENE)).errors
    speed = math.hypot(*posed.setup.velocity)
    distance = float(posed.motion.coasting.distance)
    rows = []
    for name in METHODS:
        cells: list[Cell] = []
        for step in STEPS:
            if (found := run(SCENE, name, step)) is None:
                break
            gone = np.hypot(found.observables["x"][-1], found.observables["y"][-1])
            told = theory.at_step(find_method(name).scheme, step, found.times)
            lead = math.copysign(math.hypot(told["x"][-1], told["y"][-1]), told["x"][-1])
            half = 0.5 * speed * step
            cells += [value((gone - distance) / half, 4), value(lead / half, 4)]
        if len(cells) == 2 * len(STEPS):
            rows.append(row(method_cell(name), *cells))
    if not rows:
        return ()
    heads = ("method", *(
        f"{what}, step {short(step)} s" for step in STEPS for what in ("measured", "predicted")
    ))  # fmt: skip
    return (
        Finding(
            "capsule-stopping-distance",
            "Two engines stop short and too far by the same half step",
            "confirmed",
            f"A body at {number(speed)} m/s stops after v₀²/(2fg) = {number(distance)} m wherever "
            "its slider sits. MuJoCo, which changes velocities first, falls short by v₀dt/2; "
            "pymunk, which moves first, goes too far by it.",
            (
                "The coefficient is exact but for what the last step leaves, a sawtooth of second "
                "order, and is judged, not bounded. Default contacts add what hopping costs.",
            ),
            (Table("Error of the stopping distance over v₀dt/2", heads, tuple(rows)),),
            (),
            (f"plumbob run {SCENE} mujoco/euler+coulomb --step 1e-4",
             f"plumbob run {SCENE} pymunk/feet --step 1e-4"),
        ),
    )  # fmt: skip


def _spin(study: Study) -> Sequence[Finding]:
    """Error of the heading at rest over the step, over a decade of steps, where the study has it;
    and what default contacts do."""
    if not covers(study, SPIN):
        return ()
    rows, traces, told = [], list[Trace](), dict[str, float]()
    for name in SPINNING:
        found = [measured(study, SPIN, name, step) for step in DECADE]
        errors = [m.errors["heading"] for m in found if m is not None]
        if len(errors) < len(DECADE):
            continue
        ends = [e.end for e in errors]
        traces.append(
            curve(DECADE, positive(ends), colour=COLOURS[name], marks=True, width=1.0, name=name)
        )
        last = errors[-1].predicted
        if name != DEFAULT and last is not None:
            told[name] = last.end / DECADE[-1]
            rows.append(row(named(name), *(value(e / h, 4) for e, h in zip(ends, DECADE,
                        strict=True)), value(told[name], 4)))  # fmt: skip
            traces.append(
                curve(DECADE, positive([told[name] * h for h in DECADE]), colour=COLOURS[name],
                      dash="dash", width=1.0, name=f"{number(abs(told[name]))} rad/s × step")
            )  # fmt: skip
    if not rows:
        return ()
    heads = ("method", *(f"step {short(h)} s" for h in DECADE), "predicted at the last")
    said = ", ".join(f"{name} {number(c, 4)}" for name, c in told.items())
    default = _default(study)
    summary = (
        "A body that spins and slides at once has no formula; its heading at rest is off by a "
        f"coefficient times the step, in rad/s: {said}."
    )
    if default is not None:
        off = [abs(float(line[1].text)) for line in default.rows]
        summary += (
            f" On default contacts it is off by {number(min(off), 2)} to {number(max(off), 2)} rad "
            "at these steps, with a contact missing on most samples."
        )
    return (
        Finding(
            "capsule-spin",
            "Spin and translation at once: of first order, with a known coefficient",
            "confirmed",
            summary,
            (
                "Friction couples the two, and a support comes to rest before the others do. The "
                "coefficient is predicted by taking the same steps in three degrees of freedom, "
                "with friction resolved to the last digit.",
                "Default contacts lose the ground: a body that slides hops on them, as on a line, "
                "and what each landing takes from spin and from translation is not friction's.",
            ),
            (Table("Error of the heading at rest over the step [rad/s]", heads, tuple(rows)),
             *(() if default is None else (default,))),
            (figure("Error of the heading at rest against the step",
                    "Dashed: the coefficient times the step.", traces,
                    logarithmic("step [s]"), logarithmic("|error of ψ| [rad]"), legend=True),),
            (f"plumbob validate --scenes {SPIN} --methods {','.join(SPINNING)}",
             f"plumbob run {SPIN} pymunk/feet --step 1e-4"),
        ),
    )  # fmt: skip


def _default(study: Study) -> Table | None:
    """Errors of heading and rate on default contacts, and how often one is missing."""
    rows = []
    rest = problem(SPIN).motion.rest_time
    for step in DECADE:
        found, moved = measured(study, SPIN, DEFAULT, step), run(SPIN, DEFAULT, step)
        if found is None or moved is None:
            return None
        sliding = moved.times < rest
        missing = float(np.mean(moved.channels["contacts"][sliding] < 3))
        heading, rate = found.errors["heading"], found.errors["heading_rate"]
        rows.append(row(Cell(short(step), "number"), value(heading.end), value(rate.largest),
                        value(missing, 2)))  # fmt: skip
    heads = ("step [s]", "error of the heading at rest [rad]", "largest of the rate [rad/s]",
             "samples with a contact missing while it moves")  # fmt: skip
    return Table(f"Default contacts, {DEFAULT}", heads, tuple(rows))


def _figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    return ()


def _hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    return ()


SECTION = Section(findings, _figures, _hard)
