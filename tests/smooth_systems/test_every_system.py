"""Every system with smooth degrees of freedom: its file, its invariants, and what methods make."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.registry import find_builder
from plumbob.models.registry import built_in, case_of, scenes
from plumbob.models.scene import SMOOTH

SYSTEMS = [system for system in built_in().values() if system.kind == SMOOTH]
SCENES = scenes(",".join(system.name for system in SYSTEMS))


@pytest.mark.parametrize("system", [*SYSTEMS, built_in()["servo"]], ids=lambda system: system.name)
def test_rebuilt_at_the_default_parameters_it_is_the_file(system):
    (default,) = scenes(f"{system.name}/{system.default}")
    file = mujoco.MjModel.from_xml_path(str(system.mjcf))
    rebuilt = find_builder("mujoco", system).whole(system.mjcf, case_of(default).problem).compile()
    fields = [n for n in dir(file) if isinstance(getattr(file, n), np.ndarray)]
    compared = [n for n in fields if getattr(file, n).dtype.kind in "fiu" and n[:3] != "nam"]
    for name in compared:
        values = getattr(file, name), getattr(rebuilt, name)
        np.testing.assert_allclose(*values, 1e-12, 1e-15, err_msg=name)
    np.testing.assert_array_equal(rebuilt.opt.gravity, file.opt.gravity)
    assert len(compared) > 50
    assert not file.geom_contype.any()


@pytest.mark.parametrize("chosen", SCENES, ids=lambda scene: scene.name)
def test_the_exact_motion_conserves_what_it_should(chosen):
    case = case_of(chosen)
    observed = case.reference.observe(np.linspace(0.0, case.scene.duration, 301))
    drifts = case.system.invariants(case.problem, observed)
    assert drifts
    for name, drift in drifts.items():
        assert np.abs(drift).max() < 1e-11, name
