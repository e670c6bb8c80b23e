"""Running the capsule in pymunk, for its tests."""

import math

from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.engines.adapters.pymunk import ENGINE, capsule
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.cases import run_of, verdict_of

METHODS = {m.name.partition("/")[2]: m for m in ENGINE.methods if "model" in m.settings}


def run(name, model, step, other=None, **changes):
    """One run of a scene, compared with its own answer or that of `other`, and its samples."""
    return run_of(METHODS[model], find_scene(name, changes), step, other)


def verdict(found, model):
    """The verdict on a run."""
    return verdict_of(found, METHODS[model])


def moved(line, model, step):
    """Readings of a line manoeuvre at rest, two steps after t2."""
    return ended(problem_of(line), model, step, math.ceil(line.t2 / step) + 2)


def problem_of(line):
    """A line manoeuvre in the form that engines take."""
    setup = CapsuleSetup(
        line.capsule,
        line.ends[0],
        line.direction,
        press=line.capsule.gravity,
        relative_velocity=line.relative_velocity,
    )
    return CapsuleProblem(line, line, setup)


def ended(problem, model, step, steps):
    """Readings after so many steps."""
    built = capsule.build(problem, METHODS[model], step)
    for n in range(steps):
        if built.act is not None:
            built.act(n * step)
        built.space.step(step)
    return built.read()
