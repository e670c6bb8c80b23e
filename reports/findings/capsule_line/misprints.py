"""The finding that the source's eqs. 18 and 19 are misprinted."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import printed_body_velocity
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import COLOURS, GREY, LINE, RED, problem, run
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number
from plumbob.reports.view.traces import Trace, curve, figure, linear

METHOD, STEP = "mujoco/euler+coulomb", 1e-3


def finding() -> Finding:
    """Both slips, and eq. 19 as printed beside as derived."""
    line = problem(LINE).motion
    late = np.array([line.t_star])
    printed = float(printed_body_velocity(line, late)[0])
    times = np.linspace(0.0, 1.05 * line.t2, 200)
    shown = times <= line.t_star
    witness = run(LINE, METHOD, STEP)
    traces: list[Trace] = [
        curve(times, line.body_velocity(times), colour=GREY, width=2.2, name="eq. 19 with t₁"),
        curve(times[shown], printed_body_velocity(line, times[shown]), colour=RED, dash="dash",
              width=2.2, name="eq. 19 as printed, with t"),
    ]  # fmt: skip
    seen = None
    if witness is not None:
        rates = witness.observables["velocity"]
        dots = witness.times[::5], rates[::5]
        traces.append(curve(*dots, colour=COLOURS[METHOD], marks=True, lines=False, name=METHOD))
        seen = float(np.interp(line.t_star, witness.times, rates))
    rows = (
        row("as printed", value(printed)),
        row("with t₁ in its first term", value(float(line.body_velocity(late)[0]))),
        row(f"measured, {METHOD} at {number(STEP)} s", value(seen, 2)),
    )
    return Finding(
        "capsule-misprints",
        "Eqs. 18 and 19 are misprinted",
        "corrected",
        "Eq. 18 has an angular velocity ω₂ where w₂ belongs; the second line of eq. 19 has t where "
        f"t₁ belongs, and as printed the body still moves at {number(printed)} m/s when eq. 20 "
        "has it at rest.",
        (
            "Eq. 17 gives Δξ = w₁(w₁ + w₂)t₁²/(2w₂); there is no ω₂ on a line. Eq. 11 integrated "
            "gives v_c = –(μw₁ – fg)t₁ + (μw₂ + fg)(t – t₁) after t₁, which is zero at the t* of "
            "eq. 20 and agrees with eq. 22 and with Fig. 2.",
        ),
        (Table("Velocity of the body at t*, the time of eq. 20", ("eq. 19", "v_c(t*) [m/s]"),
               rows),),
        (figure("v_c(t), printed and corrected", "The printed form is drawn until t*.", traces,
                linear("time [s]"), linear("v_c [m/s]"), legend=True, height=300),),
        ("plumbob solve capsule-line", f"plumbob run {LINE} {METHOD} --step 1e-3"),
    )  # fmt: skip
