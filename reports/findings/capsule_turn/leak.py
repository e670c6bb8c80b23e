"""The finding that a semi-implicit Euler step loses angular momentum as the slider goes round."""

from __future__ import annotations

from plumbob.analytic.errors.plane_errors import euler_lead
from plumbob.engines.study.study import Study
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule_turn.runs import JUDGED, METHODS, angle_off, epsilons, turn
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number

EULER = "mujoco/euler+coulomb"


def finding(study: Study) -> Finding | None:
    """Error at 2 tau over mu_1^2 Z^3 tau^5 h/2 by method and epsilon; None without MuJoCo."""
    ratios: dict[str, list[float]] = {}
    for name in METHODS[1:]:
        for epsilon in epsilons(study):
            if (off := angle_off(study, epsilon, name, JUDGED, "stop", own=True)) is None:
                break
            step = turn(epsilon).half_time / JUDGED
            ratios.setdefault(name, []).append(off / (euler_lead(turn(epsilon)) * step))
    if EULER not in ratios:
        return None
    one = turn(epsilons(study)[0])
    lead = euler_lead(one) * one.half_time / JUDGED
    rows = [row(named(name), *(value(r) for r in found)) for name, found in ratios.items()]
    heads = ("method", *(f"ε = {number(e)}" for e in epsilons(study)))
    return Finding(
        "capsule-turn-leak",
        "A semi-implicit Euler step loses angular momentum while the slider goes round",
        "explained",
        f"It leaves ½μ₁²Z³τ⁵h of the turn undone: {number(lead)} rad with steps of τ/{JUDGED} "
        "for a turn of one radian, whatever ε. A smaller step helps only in proportion.",
        (
            "The step takes the slider's place at its start and its velocity at its end, so the "
            "angular momentum about the common centre of mass falls by μMh v²ω each second, as if "
            "a damper held the body. Friction has no part in it.",
            "What momentum it leaves behind turns the body on after the slider has stopped, so the "
            "angle after 5τ, where the exact motion has come to rest, is off by more: at small ε "
            "friction has no time to stop that within the scene, and it is four times the error "
            "at 2τ.",
            "RK4 takes the slider along its circle, and pymunk's slider is put where it is to be "
            "at the end of every step. What they err by at small ε is of second order; Euler "
            f"would need some τ/{round(1e4 * lead * JUDGED, -3):.0f} for 1e-4 rad.",
        ),
        (
            Table(f"Error at 2τ over ½μ₁²Z³τ⁵h, steps of τ/{JUDGED}", heads, tuple(rows),
                  "Friction turns the body too, where ε is large: what the ratio lacks of 1."),
        ),
        (),
        (f"plumbob run capsule-turn/0.03-stop {EULER} --step "
         f"{turn(0.03).half_time / JUDGED:.17g}",),
    )  # fmt: skip
