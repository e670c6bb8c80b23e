"""The capsule, a body on three supports with a moving mass inside, and its six motions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from plumbob.reports.view.about.description import Description, Label, Symbol, capsule_labels

BODY = (
    "A rigid body rests at three points A₁, A₂, A₃ on a rough plane; inside it an actuator moves a "
    "mass Q, the slider, and its reaction moves the body against friction."
)
COMMON = (
    Symbol("C", "centre of mass of the body without the slider", "–"),
    Symbol("Q", "the slider", "–"),
    Symbol("A₁, A₂, A₃", "the points of support", "–"),
    Symbol("Nᵢ", "normal force of the plane at Aᵢ", "N"),
    Symbol("M, m", "mass of the body; of the slider", "kg"),
    Symbol("μ", "m/(M + m): the slider's part of all mass; not the friction"),
    Symbol("f", "coefficient of friction"),
    Symbol("g", "gravity", "m/s²"),
)
LINE = (
    Symbol("w₁, w₂", "accelerations with which the slider is pushed, and braked", "m/s²"),
    Symbol("t₁", "time of the push", "s"),
    Symbol("t*", "time when the body is at rest again", "s"),
    Symbol("Δx", "displacement of the body when it is at rest again", "m"),
)
RAIL = "M272 187l28 10m-10 1l10-1l-7-8"
SLIDING = (
    "A triangle of three bars on three feet; a ball, the slider, on a rail from the middle of one "
    "side through C towards A₁. An arrow along the rail marks w₁."
)
ON_A_LINE = capsule_labels(Label("w₁", 302, 190))
AT_REST = capsule_labels()


def _described(
    sentence: str,
    equations: tuple[str, ...],
    explained: str,
    symbols: tuple[Symbol, ...] = (),
    line: bool = False,
) -> Description:
    """A motion of the capsule; `line` where the slider is pushed along its rail."""
    return Description(
        (BODY, sentence),
        equations,
        explained,
        (*COMMON, *symbols),
        ON_A_LINE if line else AT_REST,
        (RAIL,) if line else (),
        SLIDING if line else SLIDING.partition(" An arrow")[0],
    )


DESCRIPTIONS: Mapping[str, Description] = MappingProxyType(
    {
        "capsule-line": _described(
            "On a line through C the slider is pushed hard, so that the body slides back, and "
            "braked gently, so that friction stops it: one step of the body.",
            (
                "Δx = –½ μ(w₁ + w₂)(μw₁ – fg)t₁² / (μw₂ + fg)",
                "t* = μ(w₁ + w₂)t₁ / (μw₂ + fg)",
            ),
            "Eqs. 22 and 20 of the source, exact for every triangle of supports.",
            LINE,
            line=True,
        ),
        "capsule-turn": _described(
            "The slider runs round an arc about C, quicker and then slower, and the body turns the "
            "other way.",
            ("Δψ = –μ₁Zτ² + O(ε²)", "μ₁ = μMa²/(J + μMa²),  ε = τ/T"),
            "Eq. 32 of the source, for a turn so quick that friction contributes little. The exact "
            "motion at any ε is computed from event to event: a support that stops, holds or "
            "slides again.",
            (
                Symbol("ψ", "heading of the body, from that at the start", "rad"),
                Symbol(
                    "Z, τ",
                    "angular acceleration of the slider on its arc, kept for τ, then "
                    "reversed for τ",
                    "rad/s², s",
                ),
                Symbol("a", "radius of the arc", "m"),
                Symbol("J", "moment of inertia of the body about the vertical through C", "kg m²"),
                Symbol("T", "time in which friction would stop a turn", "s"),
                Symbol("ε", "τ/T: how quick the turn is; small is quick"),
            ),
        ),
        "capsule-plan": _described(
            "A plan of turns and lines with slow returns between them brings it from one pose at "
            "rest to another.",
            ("(0, 0, 0) → (x, y, ψ): turns, then lines, joined by slow motions",),
            "The source shows that every pose can be reached; the planner makes the quickest of a "
            "few plans, each manoeuvre of it exact.",
            (Symbol("x, y, ψ", "place of the body, its heading in the world", "m, m, rad"), *LINE),
        ),
        "capsule-hold": _described(
            "The slider is fixed and gravity is tilted, to just below the tilt at which the body "
            "would slide: friction must hold it.",
            ("|tilt force| ≤ f ΣNᵢ: the body stays where it is",),
            "The exact displacement is zero; the error is the distance that the body drifts.",
        ),
        "capsule-coast": _described(
            "The slider is fixed and the body slides, spins or both, until friction has stopped "
            "it.",
            ("s = v₀²/(2fg)",),
            "The stopping distance of a body that does not spin; one that spins and slides at once "
            "has no formula, and its exact motion is computed.",
            (
                Symbol("v₀", "initial speed", "m/s"),
                Symbol("s", "distance until rest", "m"),
                Symbol("ψ", "heading of the body in the world", "rad"),
            ),
        ),
        "capsule-train": _described(
            "Manoeuvres on a line are repeated, each with a slow return of the slider and a pause, "
            "so that the body walks.",
            ("Δx(n manoeuvres) = n Δx(one)",),
            "Each manoeuvre starts from rest, so errors add up in the simplest way.",
            LINE,
            line=True,
        ),
    }
)
