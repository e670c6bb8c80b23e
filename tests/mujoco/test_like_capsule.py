"""A user's contacts on the capsule: those of the file, and every system that MuJoCo supports."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.user_file import user_method
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

LINE = "capsule-line/heading-030"
BARE = "<mujoco><option {options}/><default><geom {geom}/></default></mujoco>"
NOSLIP = 'cone="elliptic" impratio="100" noslip_iterations="10"'


def own(folder, options="", geom=""):
    """The method of a file with these options and contact defaults."""
    path = folder / "my.xml"
    path.write_text(BARE.format(options=options, geom=geom), "utf-8")
    return user_method(path)


@pytest.mark.parametrize(
    ("options", "like"),
    [
        ("", "mujoco/euler"),
        ('integrator="RK4"', "mujoco/rk4"),
        ('cone="elliptic" impratio="100"', "mujoco/euler+elliptic"),
        (NOSLIP, "mujoco/euler+elliptic+noslip"),
    ],
)
def test_a_file_that_says_what_a_method_says_is_that_method(options, like, tmp_path):
    scene = replace(find_scene(LINE), duration=0.06)
    user, _ = measure(case_of(scene), own(tmp_path, options), 1e-3)
    same, _ = measure(case_of(scene), find_method(like), 1e-3)
    other, _ = measure(case_of(scene), find_method("mujoco/euler+pyramidal"), 1e-3)
    for name, error in same.errors.items():
        assert user.errors[name].largest == error.largest  # the same numbers, to the last bit
    assert user.errors["displacement"].largest != other.errors["displacement"].largest


FIELDS = (
    ('solref="0.005 0.7"', "solref", [0.005, 0.7]),
    ('solref="-4000 -60"', "solref", [-4000.0, -60.0]),
    ('solimp="0.5 0.9 0.01 0.4 3"', "solimp", [0.5, 0.9, 0.01, 0.4, 3.0]),
    ('condim="4"', "dim", 4),
    ('condim="1"', "dim", 1),
    ('margin="0.002"', "margin", 0.002),
    ('gap="0.001"', "gap", 0.001),
)


@pytest.mark.parametrize(("geom", "field", "value"), FIELDS)
def test_every_contact_is_the_users(geom, field, value, tmp_path):
    scene = find_scene(LINE)
    model = compiled(case_of(scene), own(tmp_path, geom=geom), 1e-3).model
    assert model.npair == 3
    for row in getattr(model, f"pair_{field}"):
        assert np.all(row == np.array(value))
    assert np.all(model.pair_friction[:, :2] == scene.parameters["friction"])
