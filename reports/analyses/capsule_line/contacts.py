"""Findings on contacts: chatter of the default ones, dependence on heading, normal forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.claims import at_most, clear
from plumbob.reports.analyses.contact_terms import LOADS
from plumbob.reports.analyses.measurements import (
    LINE,
    case,
    displacement_error,
    problem,
    runs,
    scheme,
)
from plumbob.reports.view.content import (
    Cell,
    Finding,
    Statement,
    Table,
    plain_method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import OF_METHODS
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import (
    Trace,
    curve,
    figure,
    linear,
    logarithmic,
    over_time,
    positive,
)

DEFAULT, CONVERGENT = "mujoco/euler", "mujoco/euler+coulomb"
STEPS = (1e-3, 1e-4)  # [s]; the figures are at the finer one
FLOOR = 1e-14  # [m] where a vertical displacement of zero is drawn
TURNED = ("mujoco/euler", "mujoco/euler+elliptic", "mujoco/euler+coulomb", "pymunk/feet")
HEADINGS, ALL_HEADINGS = (0, 30, 105, 225), tuple(range(0, 360, 15))  # [degrees]; quick, full
STATICS, STATICS_STEP = "capsule-line/at-123", 1e-4
STATICS_METHODS = ("mujoco/euler+coulomb", "pymunk/side")
ALIKE_AT_ALL = 1e-4  # of the displacement: headings that differ by less do not tell
CHATTERS = 1e-3  # of the samples: a contact is missing in many times that
TRUSTED = 1e-3  # of a normal force: what is nearer to statics can be trusted
SETTLED = 60  # steps: contacts of damping 0.3 have come to rest


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Default and convergent contacts, the headings of the profile, and normal forces."""
    headings, steps = _turned(plan.profile)
    return (
        *runs((LINE,), (DEFAULT, CONVERGENT), STEPS),
        *runs(map(_at_heading, headings), TURNED, steps),
        *runs((STATICS,), STATICS_METHODS, (STATICS_STEP,)),
    )


def chatter(study: Study) -> Finding | None:
    """Vertical displacement, contacts and normal force over time, default against convergent; None
    where either did not run."""
    motion = problem(LINE).motion
    weight, rows = motion.capsule.weight, []
    heights, contacts, forces = list[Trace](), list[Trace](), list[Trace]()
    for name in (DEFAULT, CONVERGENT):
        for step, run in [(h, study.recording(ExtraRun(LINE, name, h))) for h in STEPS]:
            if run is None:
                return None
            height, count = run.channels["vertical_displacement"], run.channels["contacts"]
            load = np.sum([run.observables[n] for n in LOADS], axis=0) / weight
            missing = float(np.mean(count[run.times < motion.t_star] < 3))
            cells = (displacement_error(study, LINE, name, step), float(np.ptp(height)), missing,
                     float(count.min()), float(load.min()), float(load.max()))  # fmt: skip
            rows.append(row(plain_method_cell(name), Cell(short(step), "number"),
                            *map(value, cells)))  # fmt: skip
            if step == STEPS[-1]:
                for traces, drawn in ((heights, np.maximum(np.abs(height), FLOOR)),
                                      (contacts, count), (forces, load)):  # fmt: skip
                    traces.append(curve(run.times, drawn, colour=OF_METHODS[name], name=name))
    heads = ("method", "step [s]", "relative error of Δx", "vertical displacement, range [m]",
             "fraction of samples with a contact missing while it slides", "fewest contacts",
             "smallest ΣNᵢ over the weight", "largest")  # fmt: skip
    jump, missing = (float(rows[1][i].text) for i in (3, 4))
    fine = [float(rows[i][2].text) for i in (1, 3)]  # relative errors of both, at the finer step
    at = f"At a step of {short(STEPS[-1])} s."
    return Finding(
        "capsule-contact-chatter",
        "MuJoCo's default contacts chatter under a sliding body, and no step size fixes it",
        "known limit",
        "A robot that slides on MuJoCo's default contacts chatters between contact and "
        "flight, and a smaller step does not help. "
        f"While the body slides, a contact is missing in {number(100 * missing, 2)} % of the "
        f"samples at {short(STEPS[-1])} s, the body moves vertically by {number(1e6 * jump, 2)} "
        "µm, and the force on the plane varies between zero and nearly twice the weight. The same "
        "happens at smaller steps.",
        (
            "The convex friction cone couples slip speed to normal force: sliding contacts push "
            "the body off the plane, it falls back and meets more friction than its weight "
            "allows. Friction is right on average, but a manoeuvre is too short to average over. "
            "Contacts that are soft in the normal direction and stiff in the tangential one keep "
            "the weight on the plane: that is the profile coulomb.",
            "Every method with default contacts is declared not-converging, strictly: if a "
            "release of MuJoCo fixes it, the run fails and reports so.",
        ),
        (Table("Default contacts beside those that converge, ca1", heads, tuple(rows)),),
        (
            over_time("Vertical displacement of the body", f"{at} From where it rests.", heights,
                      logarithmic("|vertical displacement| [m]")),
            over_time("Supports in contact", f"{at} Of three.", contacts,
                      linear("contacts [1]", dtick=1)),
            over_time("Force on the plane", f"{at} Exact: 1.", forces,
                      linear("ΣNᵢ / (M+m)g"), wide=True, height=280),
        ),
        (f"plumbob validate --scenes {LINE} --methods {DEFAULT},{CONVERGENT}",),
        claims=(
            clear("errors with default contacts, and with those that converge", fine[0], fine[1]),
            clear("the part of samples with a contact missing, and 0.001", missing, CHATTERS),
        ),
    )  # fmt: skip


def _turned(profile: str) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Headings [degrees] and steps [s] of a profile."""
    return (ALL_HEADINGS, (1e-3, 1e-4)) if profile == "full" else (HEADINGS, (1e-3,))


def _at_heading(angle: int) -> str:
    return f"capsule-line/heading-{angle:03d}"


def isotropy(study: Study) -> Finding | None:
    """Relative error of the displacement at each heading, and its spread."""
    headings, steps = _turned(study.profile)
    rows: list[tuple[Cell, ...]] = []
    traces: list[Trace] = []
    spreads = {}
    for name in TURNED:
        for step in steps:
            every = [displacement_error(study, _at_heading(a), name, step) for a in headings]
            known = np.array([error for error in every if error is not None])
            if len(known) < len(headings):
                continue
            lowest, highest = float(known.min()), float(known.max())
            cells = (len(known), lowest, highest, highest - lowest)
            rows.append(row(plain_method_cell(name), Cell(short(step), "number"),
                            *map(value, cells)))  # fmt: skip
            if step == steps[0]:
                spreads[name] = highest - lowest
                traces.append(curve(np.array(headings), positive(known), colour=OF_METHODS[name],
                                    marks=True, name=name))  # fmt: skip
    if not rows:
        return None
    default, convergent = spreads.get(DEFAULT), spreads.get(CONVERGENT)
    text = ""
    if default is not None and convergent is not None:
        text = (
            f" Over the headings the displacement varies by {number(100 * default, 2)} % with "
            f"MuJoCo's default contacts and by {_little(convergent)} with convergent "
            "ones, which a robot that slides should take (plumbob settings prints them)."
        )
    heads = ("method", "step [s]", "headings", "lowest error", "highest error", "spread")
    return Finding(
        "capsule-isotropy",
        "Pyramidal friction depends on the heading; heading 0 hides it",
        "measured",
        f"{_of_default(study)}The scene is turned as a whole, and the exact displacement stays the "
        f"same.{text}",
        (
            "A friction pyramid of four edges reaches the coefficient f only at its edges, which "
            "lie along the contact's own axes: between them it has 0.71 f. An elliptic cone is "
            "round, but its contacts chatter too. A joint in pymunk limits the magnitude of its "
            "force, which is the same in all directions.",
        ),
        (Table("Relative error of Δx over headings", heads, tuple(rows)),),
        (figure("Error of Δx against heading", f"At a step of {short(steps[0])} s.", traces,
                linear("heading [°]", dtick=45), logarithmic("|error of Δx| / |Δx|"), legend=True,
                wide=True),),
        ("plumbob validate --profile full --scenes 'capsule-line/heading-*' --methods "
         f"{','.join(TURNED)}",),
        claims=(
            (clear("the spread over headings, with default contacts and with convergent ones",
                   default, max(convergent, ALIKE_AT_ALL)),)
            if default is not None and convergent is not None
            else ()
        ),
    )  # fmt: skip


def _little(part: float) -> str:
    """A relative spread as text: what no robot would notice is not given in digits."""
    return "less than a millionth" if part < 1e-6 else f"{number(100 * part, 2)} %"


def _of_default(study: Study) -> str:
    """How much default contacts get wrong at the best and the worst heading, in a sentence."""
    headings, steps = _turned(study.profile)
    errors = {a: displacement_error(study, _at_heading(a), DEFAULT, steps[0]) for a in headings}
    known = {a: abs(error) for a, error in errors.items() if error is not None}
    if len(known) < 2:
        return ""
    best, worst = min(known, key=lambda a: known[a]), max(known, key=lambda a: known[a])
    return (
        "On MuJoCo's default contacts a robot slides another distance in every direction: at a "
        f"step of {short(steps[0])} s the error is {number(100 * known[best], 2)} % along heading "
        f"{best}° and {number(100 * known[worst], 2)} % along {worst}°, which is "
        f"{abs((worst + 45) % 90 - 45)}° from an axis of the friction pyramid. "
    )


def normal_forces(study: Study) -> Finding | None:
    """Normal forces at rest, while the slider moves, and with half a step of its motion allowed."""
    motion = problem(STATICS).motion
    rows, traces, resting = [], list[Trace](), []
    for name in STATICS_METHODS:
        if (parts := _from_statics(study, name)) is None:
            continue
        times, distance, left = parts
        at_end = float(distance[times > motion.t2 + SETTLED * STATICS_STEP].max())
        resting.append(at_end)
        rows.append(row(plain_method_cell(name), value(at_end), value(float(distance.max())),
                        value(float(left[:-1].max()))))  # fmt: skip
        colour = OF_METHODS[name]
        traces += [
            curve(times, positive(distance), colour=colour, name=f"{name}: from statics"),
            curve(times, positive(left), colour=colour, dash="dot",
                  name=f"{name}: from statics and half a step"),
        ]  # fmt: skip
    if not rows:
        return None
    heads = ("method", "at rest at the end", "largest of all times", "with half a step allowed")
    return Finding(
        "capsule-loads",
        "Normal forces are those of statics",
        "confirmed",
        "Normal forces at rest can be trusted. "
        "At rest the normal forces Nᵢ of MuJoCo, and of pymunk in its side view, agree with "
        f"statics to {number(max(resting), 2)}, relative.",
        (
            "With heights of zero the slider's acceleration does not change the loads; only its "
            "place does. While it moves, at a grid time the engines have it half a step ahead "
            "(MuJoCo) or behind (pymunk), which is predicted; what is left in MuJoCo is the "
            "inertia of body and slider as the deflections of its contacts change, and goes with "
            "the square of the step.",
            "Seen from above, pymunk has no normal forces: in every step the feet are given the Nᵢ "
            "of statics for the slider's next place. There they are an input, not a result.",
        ),
        (Table(f"Largest relative distance of an Nᵢ, {STATICS.partition('/')[2]} at "
               f"{short(STATICS_STEP)} s", heads, tuple(rows)),),
        (over_time("Nᵢ against statics", "Largest of the three, relative.", traces,
                   logarithmic("|Nᵢ – statics| / Nᵢ"), wide=True),),
        tuple(f"plumbob run {STATICS} {name} --step 1e-4" for name in STATICS_METHODS),
        (
            Statement(
                CHERNOUSKO,
                "(5)–(7)",
                "Nᵢ are those of statics, with C and Q in the plane",
                "barycentric coordinates of μr",
                f"at rest within {number(max(resting), 2)}, relative, in the engines",
                "holds",
            ),
        ),
        claims=(
            at_most("the largest distance from statics at rest, relative,", max(resting), TRUSTED),
        ),
    )  # fmt: skip


def _from_statics(study: Study, method: str) -> tuple[Array, Array, Array] | None:
    """Times [s], and largest relative distances of the normal forces from statics, and from statics
    with the predicted error of the step."""
    if (run := study.recording(ExtraRun(STATICS, method, STATICS_STEP))) is None:
        return None
    exact = case(STATICS).reference.observe(run.times)
    predicted = case(STATICS).errors.at_step(scheme(method), STATICS_STEP, run.times).errors
    dots, truth, lead = (
        np.stack([source[load] for load in LOADS]) for source in (run.observables, exact, predicted)
    )
    distance = np.abs(dots / truth - 1.0).max(axis=0)
    left = np.abs((dots - lead) / truth - 1.0).max(axis=0)
    return run.times, distance, left
