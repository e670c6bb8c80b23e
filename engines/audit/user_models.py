"""The ability to run models of a user's own, which MuJoCo has; and contexts in which MuJoCo prints
nothing, and in which a model that cannot be certified is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import UserModels
from plumbob.engines.own_motion import NotCertifiable
from plumbob.engines.registry import find_engine


def user_models() -> UserModels:
    """Returns MuJoCo's ability to run models of a user's own."""
    models = find_engine("mujoco").ability(UserModels)
    assert models is not None
    return models


@contextmanager
def quiet() -> Iterator[None]:
    """A context in which MuJoCo neither prints nor leaves a file. An audit also steps a model
    beyond the largest step that holds, of which MuJoCo warns."""
    with user_models().quiet():
        yield


def quietly(do: Callable[..., Any], *arguments: Any) -> Any:
    """Calls a function in the context `quiet`; returns its result."""
    with quiet():
        return do(*arguments)


@contextmanager
def certifiable_model(model: Any, wanted: str) -> Iterator[None]:
    """Raises ParameterError in place of NotCertifiable: the model must be `wanted`. The message
    names the model by its path, or says "model"."""
    try:
        yield
    except NotCertifiable as reason:
        name = str(model) if isinstance(model, (str, Path)) else "model"
        raise ParameterError("model", name, f"{wanted}; {reason}") from None
