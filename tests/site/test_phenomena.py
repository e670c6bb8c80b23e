"""The table of phenomena against engines: the best of an engine's methods, and its errors."""

from types import SimpleNamespace

from plumbob.reports.view.method_results import ShownError
from plumbob.reports.view.site import phenomena

RAN = {  # by scene and method: the error at 1 ms, what it means, errors of all runs
    ("stack/a", "mujoco/euler"): (0.2, "predicted", (0.2, 0.03)),
    ("stack/b", "mujoco/euler"): (0.1, "predicted", (0.1, 0.05)),
    ("stack/a", "mujoco/chance"): (0.01, "limit", (0.01,)),
    ("stack/b", "mujoco/chance"): (0.01, "predicted", (0.01,)),
    ("stack/a", "mujoco/one"): (0.001, "predicted", (0.001,)),
    ("stack/a", "mujoco/surrogate"): (1e-4, "predicted", (1e-4,)),
    ("stack/b", "mujoco/surrogate"): (1e-4, "predicted", (1e-4,)),
    ("cone-pendulum/a", "pymunk/tight"): (0.3, "predicted", (0.3,)),
}


def test_a_cell_is_of_the_best_method_that_does_all_scenes_as_predicted():
    every = {
        (scene, name): SimpleNamespace(
            scene=SimpleNamespace(system=scene.split("/")[0]),
            method=SimpleNamespace(engine=name.split("/")[0], surrogate="surrogate" in name),
            name=name,
            at_reference=ShownError(error, 1e-3, "step", why),
            errors=dict(enumerate(errors)),
        )
        for (scene, name), (error, why, errors) in RAN.items()
    }
    study = SimpleNamespace(methods=[of.method for of in every.values()])
    systems = [SimpleNamespace(name=name, title=name) for name in ("stack", "cone-pendulum")]
    made = phenomena.phenomena(study, every, systems)
    assert made.heads == ("phenomenon", "mujoco", "pymunk")
    assert [row[1].text for row in made.rows] == ["20 %, 5 %; euler"]
    assert phenomena.phenomena(study, {}, systems) is None
