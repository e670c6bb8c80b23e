"""Energy over many steps of the source's Fig. 3."""

from __future__ import annotations

from plumbob.models.registry import scene as find_scene
from plumbob.reports.findings.cone_pendulum.problems import ROTATING, case
from plumbob.reports.findings.energy_drift import measured
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Finding, Table

METHODS = ("mujoco/euler", "ode/leapfrog", "mujoco/rk4")
STEP, DURATION = 1e-3, 10.0  # [s]: 10^4 steps, 62 turns


def finding() -> Finding:
    """Which methods keep the energy, over ten thousand steps of the source's Fig. 3."""
    table, plot, drifts = measured(ROTATING, case(ROTATING).correct, METHODS, STEP, DURATION)
    bounded = [m for m, d in drifts.items() if not d.secular]
    loose = {m: d for m, d in drifts.items() if d.secular}
    told = "; ".join(
        f"{m} drifts by {notation.number(d.rate)} J/s"
        + (f" where averaging predicts {notation.number(d.predicted)}" if d.predicted else "")
        for m, d in loose.items()
    )
    return Finding(
        "energy",
        "Symplectic methods keep the energy within bounds; RK4 lets it drift at a predicted rate",
        "confirmed",
        f"Over {DURATION / STEP:.0f} steps the energy error of {' and '.join(bounded)} stays "
        f"bounded; {told}.",
        (
            "RK4 is so exact here that its drift is far below the symplectic methods' ripple; but "
            "it grows with every turn, and the ripple does not.",
        ),
        (table,),
        (plot,),
        (
            "plumbob validate --profile full --scenes cone-pendulum/million-steps "
            f"--methods {','.join(METHODS)}",
        ),
    )


def hard(name: str) -> tuple[Figure | Table, ...]:
    """The same on the scene that is there for it, at its finest step."""
    scene = find_scene(name)
    motion = case(name).correct
    table, plot, _ = measured(name, motion, METHODS, scene.steps[-1], scene.duration)
    return plot, table
