"""The finding on normal forces: MuJoCo's and pymunk's against statics."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS, problem, run
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic, positive

SCENE, STEP = "capsule-line/at-123", 1e-4
METHODS = ("mujoco/euler+coulomb", "pymunk/side")
SETTLED = 60  # steps: contacts of damping 0.3 have come to rest
LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def finding() -> Finding | None:
    """Normal forces at rest, while the slider goes, and once half a step of its way is allowed."""
    motion = problem(SCENE).motion
    rows = []
    traces: list[Trace] = []
    resting = []
    for name in METHODS:
        if (parts := _parts(name)) is None:
            continue
        times, apart, left = parts
        rest = float(apart[times > motion.t2 + SETTLED * STEP].max())
        resting.append(rest)
        rows.append(row(named(name), value(rest), value(float(apart.max())),
                        value(float(left[:-1].max()))))  # fmt: skip
        traces += [
            curve(times, positive(apart), colour=COLOURS[name], name=f"{name}: from statics"),
            curve(times, positive(left), colour=COLOURS[name], dash="dot",
                  name=f"{name}: from statics and lead"),
        ]  # fmt: skip
    if not rows:
        return None
    heads = ("method", "at rest at the end", "largest on the way", "with half a step's way allowed")
    return Finding(
        "capsule-loads",
        "Normal forces are those of statics",
        "confirmed",
        f"At rest MuJoCo's Nᵢ and pymunk's, seen from the side, agree with statics to "
        f"{number(max(resting), 2)} of themselves.",
        (
            "With heights of zero the slider's acceleration shifts no load: only its place does. "
            "While it goes, the engines have it half a step ahead (MuJoCo) or behind (pymunk) at "
            "a grid time, which is predicted; what is left of MuJoCo's is the inertia of body and "
            "slider as the sags of its contacts change, in the square of the step.",
            "Seen from above pymunk has no normal forces: the feet are told Nᵢ by statics in every "
            "step, from where the slider will be. There it is not a result.",
        ),
        (Table(f"Largest relative distance of an Nᵢ, {SCENE.partition('/')[2]} at {short(STEP)} s",
               heads, tuple(rows)),),
        (figure("Nᵢ against statics", "Largest of the three, relative.", traces,
                linear("time [s]"), logarithmic("|Nᵢ – statics| / Nᵢ"), legend=True, wide=True),),
        tuple(f"plumbob run {SCENE} {name} --step 1e-4" for name in METHODS),
    )  # fmt: skip


def _parts(method: str) -> tuple[Array, Array, Array] | None:
    """Times [s], and largest relative distances from statics, and from what is predicted of it."""
    if (found := run(SCENE, method, STEP)) is None:
        return None
    theory = case_of(find_scene(SCENE)).errors
    exact = problem(SCENE).reference.observe(found.times)
    told = theory.at_step(find_method(method).scheme, STEP, found.times)
    seen, truth, lead = (
        np.stack([source[load] for load in LOADS]) for source in (found.observables, exact, told)
    )
    apart = np.abs(seen / truth - 1.0).max(axis=0)
    left = np.abs((seen - lead) / truth - 1.0).max(axis=0)
    return found.times, apart, left
