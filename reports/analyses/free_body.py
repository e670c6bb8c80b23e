"""The page's section on the free body: why MuJoCo's RK4 is of second order on it, and what energy
the Euler steps gain and lose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from plumbob.analytic.errors.free_body.error_series import euler_drifts
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.claims import ALIKE, as_predicted, at_most, between
from plumbob.reports.analyses.measurements import case, convergence_of, order_text
from plumbob.reports.view import notation
from plumbob.reports.view.content import (
    Cell,
    Claim,
    Finding,
    Table,
    method_cell,
    row,
    value,
)

RK4: Final = ("mujoco/rk4", "ode/rk4")
EULER: Final = ("mujoco/euler", "ode/euler", "mujoco/implicit", "mujoco/implicitfast",
                "mujoco/discrete")  # fmt: skip
SHOWN: Final = ("free-body/flip", "free-body/symmetric")  # scenes that every profile runs


def second_order(study: Study) -> Finding | None:
    """The order of the two RK4s, with the term of second order that theory predicts; None where
    MuJoCo's was not run."""
    runs = _runs(study, RK4)
    if not any(method == RK4[0] for _, method, _, _ in runs):
        return None
    rows = []
    for scene, method, study_of, run in runs:
        quantity, relative = worst(run, study.quantities(scene))
        predicted = run.errors[quantity.observable].predicted
        second = None if predicted is None else predicted.terms.get(2, 0.0) / quantity.scale
        rows.append(
            row(
                scene,
                method_cell(method),
                Cell(f"{notation.short(run.step)} s", "number"),
                value(relative),
                value(second),
                Cell(order_text(study_of.order), "number"),
            )
        )
    table = Table(
        "Relative error of the worst observable, and the term of second order in it",
        ("scene", "method", "step", "measured", "predicted h² term", "order"),
        tuple(rows),
        "The term is the largest over the run of (h²/12) ∫ ω × dω/dt dt in the world's axes, as a "
        "turn of the attitude; it is zero for the classical RK4.",
    )
    return Finding(
        "free-body-rk4-second-order",
        "MuJoCo's RK4 is of second order for a body that turns freely in three dimensions",
        "explained",
        f"{_largest(runs, study)}, because the angular velocities of the four stages are added as "
        "vectors, though each belongs to axes that have turned by then.",
        (
            "A free joint's angular velocity has components along the body's own axes. MuJoCo's "
            "RK4 takes the weighted mean of those of its four stages, and turns the body by that "
            "mean times the step. The exact turn has one more term, by Magnus' series: (h³/12) ω × "
            "dω/dt in each step, from axes that turn while ω changes. Leaving it out leaves an "
            "attitude that is (h²/12) ∫ ω × dω/dt dt behind, in the world's axes: the formula "
            "holds from both sides, at every step and sample (THEORY.md, section 12).",
            "The angular velocity itself, the energy and the magnitude of the angular momentum "
            "stay of fourth order, so that neither shows the error. A body that turns about an "
            "axis which is fixed in it has ω × dω/dt = 0, and its RK4 is of fourth order: no "
            "pendulum shows it.",
        ),
        (table,),
        (),
        tuple(
            f"plumbob validate --scenes {scene} --methods {','.join(RK4)}"
            for scene in dict.fromkeys(scene for scene, *_ in runs)
        )[:2],
        claims=(
            *(
                between(f"the order of {method} on {scene}", of.order.slope, 1.5, 2.5)
                for scene, method, of, _ in runs
                if method == RK4[0] and of.order is not None
            ),
            *(
                claim
                for scene, method, _, run in runs
                if method == RK4[0]
                for claim in _beside_second(study, scene, run)
            ),
        ),
    )


def energy(study: Study) -> Finding | None:
    """The energy that first-order steps gain or lose, beside what theory predicts; None where none
    of them was run."""
    runs = [entry for entry in _runs(study, EULER) if "energy" in entry[3].invariants]
    if not runs:
        return None
    rows, off = [], 0.0
    for scene, method, _, run in runs:
        implicit = "implicit" in method or "discrete" in method
        rate = euler_drifts(case(scene).problem, case(scene).scene.duration)["energy"]
        predicted = (-1.0 if implicit else 1.0) * rate * run.step
        measured = run.invariants["energy"]
        off = max(off, abs(measured / abs(predicted) - 1.0)) if predicted else off
        rows.append(
            row(
                scene,
                method_cell(method),
                Cell(f"{notation.short(run.step)} s", "number"),
                value(measured),
                value(predicted),
            )
        )
    table = Table(
        "Relative drift of the energy over the run",
        ("scene", "method", "step", "measured, magnitude", "predicted, with its sign"),
        tuple(rows),
        "Predicted: ± h/2 times the integral of dω/dt · I dω/dt, over the energy; the next term of "
        "the series is of second order in the step.",
    )
    return Finding(
        "free-body-energy",
        "Euler's step gives a free body energy, and the implicit ones take as much away",
        "confirmed",
        "To first order in the step the drift is ± (h/2) ∫ dω/dt · I dω/dt dt, plus for "
        "semi-implicit Euler and minus for the implicit steps; the measured drift is within "
        f"{100 * off:.2g} % of it.",
        (
            "The gyroscopic torque does no work, but a step along it does: it is at a right angle "
            "to the velocity where the step begins, and no more where it ends. MuJoCo's implicit, "
            "implicitfast and discrete are one method on this body: all three take the derivative "
            "of that torque into the step, which takes twice the gain away.",
        ),
        (table,),
        (),
        (f"plumbob run {runs[0][0]} {runs[0][1]} --step 1e-3",),
        claims=(at_most("the drift's distance from the predicted one, relative,", off, ALIKE),),
    )


def _runs(
    study: Study, methods: Sequence[str]
) -> list[tuple[str, str, ConvergenceStudy, Measurement]]:
    """Scene, method, convergence study and the run nearest to a millisecond."""
    runs = []
    for scene in SHOWN:
        for method in methods:
            if (of := convergence_of(study, scene, method)) is None:
                continue
            if (run := reference_run(of.measurements, find_method(method))) is not None:
                runs.append((scene, method, of, run))
    return runs


def _beside_second(study: Study, scene: str, run: Measurement) -> Sequence[Claim]:
    """That the error is the predicted term of second order; nothing where there is none."""
    quantity, relative = worst(run, study.quantities(scene))
    predicted = run.errors[quantity.observable].predicted
    if predicted is None or 2 not in predicted.terms:
        return ()
    term = predicted.terms[2] / quantity.scale
    return (as_predicted(f"the relative error on {scene}", relative, term),)


def _largest(runs: Sequence[tuple[str, str, ConvergenceStudy, Measurement]], study: Study) -> str:
    scene, _, _, run = next(entry for entry in runs if entry[1] == RK4[0])
    size = worst(run, study.quantities(scene))[1]
    where = scene.partition("/")[2]
    at = f"{where} at {notation.short(run.step)} s"
    return f"The relative error is {notation.number(size, 2)} on {at}"


SECTION = Section((second_order, energy))
