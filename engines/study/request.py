"""Requests for what analyses need beside a study's own runs: data that makes its own answer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Generic, TypeVar, cast, get_args

from plumbob.analytic.parameters import known
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene

Answer = TypeVar("Answer")
_SEARCH_WORK = 2e5  # equivalent number of steps of a search by runs, roughly
Changes = tuple[tuple[str, Any], ...]  # by name; hashable values
# equivalent number of steps for the tolerances of an adaptive method, roughly
_ADAPTIVE_WORK = 1e5


class Request(ABC, Generic[Answer]):
    """A request for an answer of one kind."""

    timed: ClassVar[bool] = False  # made alone, for its time counts

    @classmethod
    def kind(cls) -> type[Any]:
        """The class of its answers, which its base names: `Request[Answer]`."""
        bases: tuple[Any, ...] = vars(cls)["__orig_bases__"]
        (kind,) = get_args(bases[0])
        return cast("type[Any]", kind)


class RunRequest(Request[Answer]):
    """A request for what runs of a method on a scene tell."""

    scene: str
    method: str
    changes: Changes = ()  # parameters changed, as `--set` has them
    duration: float | None = None  # [s]; None: the scene's own
    label: ClassVar[str] = ""  # what progress says of it
    of_pair: ClassVar[bool] = False  # kept with its scene and method
    as_planned: ClassVar[bool] = False  # of the scene with the parameters that a study runs

    def posed(self) -> Scene:
        """The scene with its parameters and its duration; raises ParameterError."""
        scene = find_scene(self.scene)
        if self.changes:
            system = system_of(scene)
            changes = dict(self.changes)
            known(changes, system.parameters)
            scene = replace(scene, parameters=system.change(scene.parameters, changes))
        return scene if self.duration is None else replace(scene, duration=self.duration)

    def answer(self, method: Method, planned: Scene | None = None) -> Answer | None:
        """The answer by the request's method, on the scene `planned`, else the one posed; None
        where its engine is missing, it is not meant for the scene or does not support it, or its
        run diverged. Raises ParameterError."""
        scene = planned or self.posed()
        if not installed(engine_of(method)) or not meant(method, scene):
            return None
        try:
            return self.made(scene, method)
        except Unsupported:
            return None

    @abstractmethod
    def made(self, scene: Scene, method: Method) -> Answer | None:
        """The answer on the posed scene, by a method that is installed and meant for it."""

    def work(self, scene: Scene, method: Method) -> float:
        """Roughly how many steps of a pendulum it takes."""
        return _SEARCH_WORK * system_of(scene).weight


def work_of(scene: Scene, method: Method, steps: Sequence[float]) -> float:
    """Roughly how long runs take with these steps: a step costs more in Python than in C."""
    if method.control == "tolerance":
        return _ADAPTIVE_WORK
    count = sum(scene.duration / h for h in steps)
    return count * system_of(scene).weight * (1.0 if method.engine == "mujoco" else 2.0)
