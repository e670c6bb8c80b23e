"""pymunk as an engine: its methods and abilities. pymunk is imported when one of them is called."""

from __future__ import annotations

from plumbob.engines.abilities import Settings, SettingsToPaste
from plumbob.engines.adapters.pymunk.methods import METHODS
from plumbob.engines.method import Engine, Method, ModelError, Simulation
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.pymunk.runs import prepared

    return prepared(case, method, step)


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Returns bounds on the error of each observable, by reason; raises Unsupported."""
    from plumbob.engines.adapters.pymunk import model_errors

    return model_errors.model_error(case, method, step)


def _settings(
    method: Method, step: float, stiffness: float | None, friction: float
) -> Settings:
    """Returns the settings to paste for `method` at `step` [s]; raises ParameterError."""
    from plumbob.engines.adapters.pymunk.settings_to_paste import settings

    return settings(method, step, stiffness, friction)


ENGINE = Engine(
    "pymunk",
    "pymunk",
    METHODS,
    prepare,
    model_error,
    abilities=(SettingsToPaste(_settings),),
)
