"""The finding on contacts that sag while the slider pulls with up to 1e5 N."""

from __future__ import annotations

import numpy as np

from plumbob.engines.study.results import Study
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule_turn.runs import JUDGED, epsilons, seen, turn
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number

CONVERGENT, DEFAULT = "mujoco/euler+coulomb", "mujoco/euler"
SAG = "sag of the contacts"


def finding(study: Study) -> Finding | None:
    """Heave, and the error at rest beyond what the step does, default against convergent; None
    where the study has no such runs."""
    rows, heaves, beyond = [], dict[str, list[float]](), dict[str, list[float]]()
    for epsilon in epsilons(study):
        for name in (CONVERGENT, DEFAULT):
            found = seen(study, epsilon, name, JUDGED)
            error = None if found is None else found.errors["body_angle"]
            if found is None or error is None or error.predicted is None:
                continue
            left = error.end - error.predicted.end
            heaves.setdefault(name, []).append(found.channels["heave"])
            beyond.setdefault(name, []).append(abs(left))
            rows.append(
                row(value(epsilon), named(name), value(pull(epsilon), 2),
                    value(found.channels["heave"], 2), value(left, 2),
                    value(error.model.get(SAG), 2))
            )  # fmt: skip
    if set(heaves) != {CONVERGENT, DEFAULT}:
        return None
    heads = ("ε", "method", "slider's largest pull [N]", "heave, top to bottom [m]",
             "error at rest beyond the step's [rad]", "bound of it by sag [rad]")  # fmt: skip
    return Finding(
        "capsule-turn-sag",
        "Small ε does not suffer from sagging contacts whose stiffness goes with the step",
        "measured",
        "A horizontal pull at the height of the sag tips the body. Contacts of frequency 0.4/dt "
        f"sag by {number(max(heaves[CONVERGENT]), 2)} m or less, less the smaller ε, and add "
        f"{number(max(beyond[CONVERGENT]), 2)} rad or less to the turn; default contacts heave by "
        f"up to {number(1e3 * max(heaves[DEFAULT]), 2)} mm and add up to "
        f"{number(max(beyond[DEFAULT]), 2)} rad.",
        (
            "Normal forces are those of the weight, whatever ε is. The slider's centripetal "
            "force grows as ε⁻², but the step is a part of τ, so a stiffness of (0.4/dt)² grows as "
            "fast: the moment of the pull stays the same, and acts for a time in proportion to ε. "
            "Default contacts keep their 20 ms, the sag stays, and the pull makes the body leap.",
        ),
        (Table(f"Steps of τ/{JUDGED}, at rest", heads, tuple(rows),
               "No bound is claimed for default contacts."),),
        (),
        ("plumbob validate --profile full --scenes capsule-turn/0.3,capsule-turn/0.001 "
         f"--methods {DEFAULT},{CONVERGENT}",),
    )  # fmt: skip


def pull(epsilon: float) -> float:
    """Largest force that moves the slider in the body [N], to leading order: m times |w|."""
    one = turn(epsilon)
    _, _, push = one.path.kinematics(np.array([one.half_time * (1.0 - 1e-9)]))
    return float(one.capsule.slider_mass * np.hypot(*push[0]))
