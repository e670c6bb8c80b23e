"""Normal forces of motions in the plane: predicted and bounded tightly; small mistakes are seen."""

import pytest

from plumbob.models.registry import scene
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.mujoco_capsule import LOADS, run, verdict

TURN, SPIN, PLAN = "capsule-turn/0.3", "capsule-coast/spin", "capsule-plan/near-free"
ROTATION = "capsule-coast/rotation"
BOTH = pytest.mark.parametrize("method", ["euler+coulomb", "rk4+coulomb"])


def allowed(error):
    """What theory leaves open beside the prediction [N]."""
    return sum(error.model.values())


def off(found):
    """Whether any normal force is off its prediction."""
    return any(beyond(found.errors[load]) > allowed(found.errors[load]) for load in LOADS)


@pytest.mark.long(keep=3)
@BOTH
@pytest.mark.parametrize(("name", "part"), [(TURN, 2), (SPIN, 2), (ROTATION, 2), (PLAN, 1)])
def test_normal_forces_are_predicted_and_bounds_are_tight(name, part, method):
    found, _ = run(name, method, scene(name).steps[part])
    assert verdict(found, method) == "predicted"
    for load in LOADS:
        error = found.errors[load]
        assert beyond(error) <= allowed(error) < 10 * beyond(error), load


@pytest.mark.long(keep=1)
@BOTH
@pytest.mark.parametrize(("name", "part"), [("capsule-turn/pivot", 3), (SPIN, 2)])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_mass_distribution_off_by_a_thousandth(name, part, method, sign):
    mass = scene(name).parameters["slider_mass"] * (1 + sign * 1e-3)
    wrong = scene(name, {"slider_mass": mass, "body_mass": 1.3 - mass})
    step = scene(name).steps[part]
    assert not off(run(name, method, step)[0])
    assert off(run(name, method, step, other=wrong)[0])
