"""Cases for sensitivity tests: one scene is run and compared with the answer to another."""

from dataclasses import dataclass, replace
from functools import lru_cache

from plumbob.engines.method import Method
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.judge.verdict import judge


def held_against(case, other):
    """The case with the exact motion of `other` and its predictions."""
    return replace(case, reference=other.reference, errors=other.errors)


def run_of(method, scene, step, other=None):
    """One run of a scene, compared with its own answer or that of `other`, and its samples."""
    return _measured(_Run(scene, method, step, other))


@dataclass(frozen=True, eq=False)
class _Run:
    """What is run, and what it is held against: the same if it says the same."""

    scene: Scene
    method: Method
    step: float
    other: Scene | None

    def __eq__(self, other):
        return isinstance(other, _Run) and repr(self) == repr(other)

    def __hash__(self):
        return hash(repr(self))


@lru_cache(maxsize=64)
def _measured(asked):
    """A measurement that neighbouring tests need, made once; forgotten where a formula or an
    adapter is replaced."""
    case = case_of(asked.scene)
    if asked.other is not None:
        case = held_against(case, case_of(asked.other))
    found, trajectory = measure(case, asked.method, asked.step)
    assert trajectory is not None, found
    return found, trajectory


def verdict_of(found, method):
    """The verdict on a run of a scene as it stands in its system."""
    return judge(found, system_of(find_scene(found.scene)), method).verdict


def beyond(error):
    """The part of an error that theory, which must predict it for this step, does not."""
    assert error.predicted.for_this_step
    return error.predicted.beyond


def error_of_run(name, method_name, step, lasting=None, changes=(), **settings):
    """The relative error of one run of a method with more settings, on a scene with some of its
    parameters changed, which lasts as long as the scene, or `lasting` [s]."""
    method = find_method(method_name)
    scene = find_scene(name)
    parameters = system_of(scene).change(scene.parameters, dict(changes))
    case = case_of(replace(scene, parameters=parameters))
    changed = replace(method, settings={**method.settings, **settings}, systems=("*",))
    shorter = case if lasting is None else case.lasting(lasting)
    return relative_error(measure(shorter, changed, step)[0], case.system.quantities(case))
