"""Bodies that are not round or have no symmetry: closed forms beside runs of engines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType

from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    FULL_MODEL_METHOD,
    FULL_MODEL_STEP,
    LAGRANGE,
    LAGRANGE_RTOL,
    ROTATING,
    end_angle,
)
from plumbob.reports.analyses.measurements import case

UNEQUAL = "cone-pendulum/unequal-inertia"
PRODUCT = 0.029  # [kg m^2] product of inertia; the cone's other moments allow at most 0.0294
TILTED_BODY: Changes = (("inertia_yz", PRODUCT),)
TILTED_BODY_AND_PIVOT: Changes = (*TILTED_BODY, ("pivot_x", 0.5), ("pivot_z", -0.7))  # [m]
OF_INERTIA = MappingProxyType(
    {"mujoco": ExtraRun(UNEQUAL, FULL_MODEL_METHOD, FULL_MODEL_STEP, END)}
)
OF_PRODUCT = MappingProxyType(
    {
        "mujoco": ExtraRun(ROTATING, FULL_MODEL_METHOD, FULL_MODEL_STEP, END, TILTED_BODY),
        "lagrange": ExtraRun(ROTATING, LAGRANGE, LAGRANGE_RTOL, END, TILTED_BODY),
        "moved": ExtraRun(
            ROTATING, FULL_MODEL_METHOD, FULL_MODEL_STEP, END, TILTED_BODY_AND_PIVOT
        ),
    }
)


def inertia(study: Study) -> Record:
    """Returns the comparison for a body with another I_y: MuJoCo, the formula with I_y, and the
    formula with the printed I_x."""
    problem = case(UNEQUAL).problem
    body = problem.body
    printed = replace(problem, body=replace(body, inertia_y=body.inertia_x))
    term = body.inertia_y - body.inertia_x
    return _effect_of_term(study, term, problem, printed, OF_INERTIA)


def product_of_inertia(study: Study) -> Record:
    """Returns the comparison for a body with a product of inertia: the closed form in tilted axes,
    and engines that use no such axes."""
    problem = case_of(find_scene(ROTATING, dict(TILTED_BODY))).problem
    upright = replace(problem, body=replace(problem.body, inertia_yz=0.0))
    return _effect_of_term(study, PRODUCT, problem, upright, OF_PRODUCT)


def _effect_of_term(
    study: Study,
    term: float,
    problem: ConePendulum,
    without: ConePendulum,
    requests: Mapping[str, ExtraRun],
) -> Record:
    """Returns the comparison of engines with the closed forms of a body (`problem`) and of the body
    without one term of inertia (`without`). The source's cone lacks that `term` [kg m^2]."""
    recorded = {name: study.answer(request) for name, request in requests.items()}
    runs = {name: float(run.observables["theta"][-1]) for name, run in recorded.items() if run}
    exact = end_angle(problem.reference)
    bare = end_angle(without.reference)
    gaps = {name: theta - exact for name, theta in runs.items()}
    both = {"mujoco", "moved"} <= runs.keys()
    return Record(
        scene=requests["mujoco"].scene,
        term=term,  # [kg m^2]
        tilt=problem.tilt,  # [rad] tilt of the principal axes
        exact=exact,  # [rad] theta of the closed form at END
        without=bare,  # [rad] theta of the closed form without the term at END
        runs=runs,
        time=END,
        mujoco=FULL_MODEL_METHOD,
        step=FULL_MODEL_STEP,
        moved=bare - exact,  # [rad] effect of the term on theta at END
        gaps=gaps,  # [rad] differences of the runs' ends from the closed form
        worst=max(map(abs, gaps.values()), default=0.0),  # [rad]
        # [rad] effect of another pivot on the end of MuJoCo's run
        carried=abs(runs["moved"] - runs["mujoco"]) if both else None,
    )


def _claims(text: str, numbers: Record) -> Claims:
    """Returns the check that the term moves the end far more than the engines' error."""
    return (clearly_larger(text, numbers.moved, numbers.worst, "rad"),)


INERTIA = Analysis(
    "cone_pendulum/inertia_y",
    inertia,
    lambda plan: tuple(OF_INERTIA.values()),
    partial(_claims, "distances of the printed formula, and of MuJoCo, from that with I_y,"),
)
PRODUCT_OF_INERTIA = Analysis(
    "cone_pendulum/no_symmetry",
    product_of_inertia,
    lambda plan: tuple(OF_PRODUCT.values()),
    partial(_claims, "the motion by the product of inertia, and the engines' distance,"),
)
