"""The finding that a pose can be reached: time, manoeuvres, and what choosing them saves."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule_plan.plans import command, naive, plan_of, scenes
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import number

HEADS = ("plan", "x, y [m], ψ [rad]", "time [s]", "turns", "lines", "all manoeuvres",
         "naive: time [s]", "turns", "lines", "naive over best",
         "reference off by [m]", "[rad]")  # fmt: skip


def finding(study: Study) -> Finding | None:
    """Each plan that the study has, against the naive one; None without any."""
    chosen = scenes(study)
    if not chosen:
        return None
    factors = [naive(s.name).duration / plan_of(s.name).duration for s in chosen]
    worst = max(max(plan_of(s.name).error) for s in chosen)
    span = number(min(factors), 2)
    if len(factors) > 1:
        span += f" to {number(max(factors), 2)}"
    note = (
        "Naive: as few equal turns and lines as possible, w₁ = 3fg/μ, w₂ = 0.8fg/μ, μ₁Z = 3R₀, a "
        "slow return after each. All manoeuvres: with slow motions and waits."
    )
    if study.profile != "full":
        note += " The full profile has five poses on both tracks."
    return Finding(
        "capsule-plan-poses",
        "Any pose can be reached, and choosing the manoeuvres for time pays",
        "confirmed",
        f"{_many(chosen)} in the exact motion within {number(worst, 1)} of the pose, in metres and "
        f"radians; the naive plan takes {span} times as long.",
        (
            "Turns to the heading wanted, lines to the place that is then left, slow motions "
            "between, and a wait for every residual motion. The planner chooses the number and "
            "size of turns and lines, w₁, w₂, t₁, Z and τ for the least time it finds, under "
            "limits on |w|, the stroke and the circle's radius. Every turn is followed by the "
            "exact motion to rest, for eq. 32 would miss by ε².",
            "On the free plane one line along any direction through C is enough for the "
            "translation. On the source's curve, segment, arc and segment, the slider has one "
            "freedom, needs two lines' directions, and comes back after each.",
        ),
        (Table("Plans", HEADS, tuple(_row(scene) for scene in chosen), note),),
        (),
        (command(chosen[0].name),
         "plumbob validate --profile full --scenes 'capsule-plan/*' --methods pymunk/feet"),
    )  # fmt: skip


def _many(chosen: Sequence[Scene]) -> str:
    names = [scene.name.partition("/")[2] for scene in chosen]
    return f"All {len(names)} plans end" if len(names) > 1 else f"The plan {names[0]} ends"


def _row(scene: Scene) -> tuple[Cell, ...]:
    best, other = plan_of(scene.name), naive(scene.name)
    goal, (distance, angle) = best.goal, best.error
    return row(
        scene.name.partition("/")[2],
        f"{goal.x:g}, {goal.y:g}, {number(goal.heading)}",
        value(best.duration, 4), value(best.turns), value(best.lines),
        value(len(best.manoeuvres)), value(other.duration, 4), value(other.turns),
        value(other.lines), value(other.duration / best.duration), value(distance, 1),
        value(angle, 1),
    )  # fmt: skip
