"""A small measured study with several kinds of bodies in two engines: for the tests of the choice
on the index, and of two methods side by side."""

from functools import cache

from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import matching_scenes
from plumbob.reports.advice.simulated_kinds import ADVISED_METHODS, step_requests
from plumbob.tests.sharing.shared import shared
from plumbob.tests.support.studies import recorded

SCENES = (
    "capsule-line/ca1,capsule-coast/translation,servo/*,pinch/0.5,incline/rest,incline/stops"
)
PYMUNK = ("pymunk/contact", "pymunk/spring")


@cache
def study():
    """The study with the records of its pages, measured once a run of pytest."""
    return shared("chosen-study", _measured)


def _measured():
    methods = find_methods(",".join((*ADVISED_METHODS, *PYMUNK)))
    scenes = matching_scenes(SCENES, "quick")
    command = f"plumbob validate --scenes '{SCENES}'"
    return recorded(run_study(scenes, methods, requests=step_requests, command=command))
