"""Running the capsule in MuJoCo, for its tests."""

import numpy as np

from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.cases import run_of, verdict_of

METHODS = {m.name.partition("/")[2]: m for m in ENGINE.methods}
DEFAULT_SETTINGS = ("euler", "implicitfast", "rk4", "euler+pyramidal", "euler+elliptic")
GOOD = ("euler+coulomb", "euler+coulomb+noslip", "implicitfast+coulomb", "rk4+coulomb")
REDUCED = ("euler+reduced", "rk4+reduced")
LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def run(name, method, step, other=None, **changes):
    """One run of a scene, compared with its own answer or that of `other`, and its samples."""
    return run_of(METHODS[method], find_scene(name, changes), step, other)


def verdict(found, method):
    """The verdict on a run."""
    return verdict_of(found, METHODS[method])


def loads(name, method, step):
    """Normal forces [N] of a run, of statics, and the prediction of their difference: (3, n)."""
    _, run_ = run(name, method, step)
    case = case_of(find_scene(name))
    predicted = case.errors.at_step(METHODS[method].scheme, step, run_.times).errors
    exact = case.reference.observe(run_.times)
    return (
        np.stack([run_.observables[load] for load in LOADS]),
        np.stack([exact[load] for load in LOADS]),
        np.stack([predicted[load] for load in LOADS]),
    )
