"""pymunk as an engine: its methods, and the translation of a scene to a space."""

from __future__ import annotations

from plumbob.engines.abilities import Settings, SettingsToPaste
from plumbob.engines.adapters.pymunk.methods import METHODS
from plumbob.engines.method import Engine, Method, ModelError, Simulation
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build the space of `case` for `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.pymunk.simulation import prepared

    return prepared(case, method, step)


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on what the model adds to each observable, by reason; raises Unsupported."""
    from plumbob.engines.adapters.pymunk.simulation import builder

    return builder(case.system).model_error(case.problem, case.scene.duration, method, step)


def settings_text(
    method: Method, step: float, stiffness: float | None, friction: float
) -> Settings:
    """Settings to paste for `method` at `step` [s]; raises ParameterError. Works without pymunk."""
    from plumbob.engines.adapters.pymunk.settings_to_paste import settings

    return settings(method, step, stiffness, friction)


ENGINE = Engine(
    "pymunk",
    "pymunk",
    METHODS,
    prepare,
    model_error,
    abilities=(SettingsToPaste(settings_text),),
)
