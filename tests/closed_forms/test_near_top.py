"""A pendulum released next to its top, by the complement of its angle: the start of engines that
store the angle as a double. Its exact motion is held to 40 digits in test_pendulum_motion."""

import pytest
from gmpy2 import mpfr

from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.high_precision import PI


def problem(name, **changes):
    """The problem of a scene of the simple pendulum, with parameters changed."""
    scene = find_scene(f"simple-pendulum/{name}", changes)
    found = system_of(scene).problem(scene.parameters)
    assert isinstance(found, SimplePendulum)
    return found


@pytest.mark.parametrize("k", [1, 6, 9, 12])
@pytest.mark.parametrize("method", ["mujoco/rk4", "ode/leapfrog", "ode/dop853", "pymunk/tight"])
def test_engines_start_at_the_nearest_double(k, method):
    scene, how = find_scene(f"simple-pendulum/near-top-1e-{k}"), find_method(method)
    step = 1e-12 if how.control == "tolerance" else 2e-3
    run = engine_of(how).prepare(case_of(scene), how, step).run()
    theta = float(run.observables["theta"][0])
    wanted = float(PI - mpfr(f"{10.0**-k!r}"))
    assert theta == wanted == problem(f"near-top-1e-{k}").started.theta


def test_the_error_bar_covers_rounding_of_the_start():
    # The error of an integrator of accuracy 1e-15 is this one; at 1e-12 it is 4.2e-4 rad.
    pytest.importorskip("heyoka")
    for k, size in ((6, 3.6e-10), (9, 4.1e-7), (12, 4.2e-4)):
        scene, how = find_scene(f"simple-pendulum/near-top-1e-{k}"), find_method("heyoka/taylor")
        found = measure(case_of(scene), how, 1e-15)[0]
        assert found.steps > 300  # one evaluation an order of each step, of some twenty
        error = found.errors["theta"]
        assert error.largest == pytest.approx(size, rel=0.15)
        assert error.largest < error.uncertainty < 10 * error.largest
