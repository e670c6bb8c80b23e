"""A sweep's errors are those of single runs, however it is cut into pieces and resumed."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.box import Side, box
from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.engines.sweep import store
from plumbob.engines.sweep.sweep import run_error, sweep, sweep_of
from plumbob.models.registry import case_of, scene

HEADING = Side("heading", 0.0, 6.0)
RUNS = (
    ("capsule-line", "mujoco/euler"),
    ("capsule-hold", "mujoco/euler+coulomb"),
    ("simple-pendulum", "pymunk/default"),
    ("cone-pendulum", "mujoco/rk4"),
)


def small(step=1e-3):
    """Twelve points of the capsule on a line, three of them without an exact answer, in three
    pieces."""
    around = box("capsule-line", {}, [HEADING, Side("friction", 0.2, 0.5)])
    return replace(sweep_of(around, (3, 4), [method("mujoco/euler")], [step]), chunk=5)


def forgotten(number, chunk):
    """Keep nothing."""


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(("name", "tried"), RUNS)
def test_the_error_of_a_run_is_the_study_s(name, tried):
    case = case_of(scene(name))
    chosen = method(tried)
    found, _ = measure(case, chosen, 2e-3)
    assert run_error(case, chosen, 2e-3) == relative_error(found, case.system.quantities(case))


def test_every_point_is_the_run_of_its_own_parameters():
    found = sweep(small(), {}, forgotten)
    assert found.errors.shape == (1, 1, 3, 4)
    assert found.reasons == {"w2 must be at most f g/mu = … m/s^2": 3}
    assert np.isnan(found.errors[0, 0, :, 0]).all()
    chosen = case_of(scene("capsule-line", {"heading": 3.0, "friction": 0.4}))
    assert found.errors[0, 0, 1, 2] == run_error(chosen, method("mujoco/euler"), 1e-3)
    (point, largest), *_ = found.worst(0, 0, 3)
    assert largest == np.nanmax(found.errors)
    assert found.errors.ravel()[point] == largest


@pytest.mark.long
def test_two_processes_give_the_same_to_the_bit():
    alone = sweep(small(), {}, forgotten)
    shared = sweep(small(), {}, forgotten, jobs=2)
    assert np.array_equal(alone.errors, shared.errors, equal_nan=True)
    assert alone.reasons == shared.reasons


def test_a_sweep_that_was_cut_off_goes_on(tmp_path):
    asked = small()
    file = tmp_path / store.FILE
    made = []
    with store.keeping(file, asked) as (nothing, keep):
        assert nothing == {}

        def cut(number, chunk):
            keep(number, chunk)
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            sweep(asked, {}, cut)
    with store.keeping(file, asked) as (there, _):
        assert list(there) == [0]
    found = sweep(asked, there, lambda number, chunk: made.append(number))
    assert made == [1, 2]
    assert np.array_equal(found.errors, sweep(asked, {}, forgotten).errors, equal_nan=True)
    with store.keeping(file, small(2e-3)) as (other, _):
        assert other == {}  # another step is another sweep


def test_a_box_keeps_what_is_changed():
    around = box("capsule-line", {"friction": 0.4}, [HEADING])
    assert around.parameters((0.5,)) == {"friction": 0.4, "heading": 3.0}
    assert around.case((0.5,)).scene.parameters["friction"] == 0.4
