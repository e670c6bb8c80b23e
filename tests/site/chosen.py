"""A small measured study with several kinds of bodies in two engines: for the tests of the choice
on the index, and of two methods side by side."""

from dataclasses import replace
from functools import cache

from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.runner import run_study
from plumbob.engines.study.stability import StabilitySearch
from plumbob.models.registry import matching_scenes
from plumbob.reports.advice.simulated_kinds import ADVISED_METHODS, step_requests
from plumbob.tests.sharing.shared import shared
from plumbob.tests.site.stored_runs import relative_error
from plumbob.tests.support.studies import recorded

LIMITED = "linear-pendulum/overdamped"  # its largest stable steps are predicted
SCENES = (
    "capsule-line/ca1,capsule-coast/translation,servo/*,pinch/0.5,incline/rest,incline/stops,"
    "rolling-ball/slide-to-roll," + LIMITED
)
PYMUNK = ("pymunk/contact", "pymunk/spring")
# [ns] computing time of a step in turn, method by method; timed ones would take ten times as long
COSTS = (1000.0, 1100.0, 4000.0, 4200.0, 1500.0, 5600.0, 1050.0, 900.0, 1300.0)


@cache
def study():
    """The study with the records of its pages, measured once a run; its costs are invented."""
    return shared("chosen-study", _measured)


def error_of(run):
    """The relative error of a run of the study."""
    quantities = study().quantities(run.scene)
    errors = [run.errors[quantity.observable] for quantity in quantities]
    return relative_error(
        (error.end, error.largest, quantity.when, quantity.scale)
        for quantity, error in zip(quantities, errors, strict=True)
    )


def _requests(plan):
    """The runs that the choice needs, and the largest stable steps of one scene."""
    limits = (StabilitySearch(LIMITED, name, False) for name in ADVISED_METHODS)
    return (*step_requests(plan), *(of for of in limits if plan.has(LIMITED, of.method)))


def _measured():
    methods = find_methods(",".join((*ADVISED_METHODS, *PYMUNK)))
    scenes = matching_scenes(SCENES, "quick")
    command = f"plumbob validate --scenes '{SCENES}'"
    study = run_study(scenes, methods, timed=False, requests=_requests, command=command)
    by_method = dict(zip((*ADVISED_METHODS, *PYMUNK), COSTS, strict=True))
    costs = {
        (series.scene, series.method): Cost(ns, ns, ns, ns / 1000.0, 0.0, 5)
        for series in study.convergence
        for ns in [by_method[series.method]]
    }
    return recorded(replace(study, costs=costs))
