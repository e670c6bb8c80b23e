"""Requests of analyses for more than a study's convergence runs. A request is data, and has a
method that computes its answer."""

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
_SEARCH_WORK = 2e5  # approximate number of steps of a search by runs
_ADAPTIVE_WORK = 1e5  # approximate number of steps, in time, of an adaptive method's tolerances
Changes = tuple[tuple[str, Any], ...]  # names and hashable values


class Request(ABC, Generic[Answer]):
    """A request for an answer of one kind."""

    timed: ClassVar[bool] = False  # whether its time counts: nothing else then runs beside it

    @classmethod
    def kind(cls) -> type[Any]:
        """The class of the answers, which is the argument of the base class: `Request[Answer]`."""
        bases: tuple[Any, ...] = vars(cls)["__orig_bases__"]
        (kind,) = get_args(bases[0])
        return cast("type[Any]", kind)


class RunRequest(Request[Answer]):
    """A request that is answered by runs of a method on a scene."""

    scene: str
    method: str
    changes: Changes = ()  # changed parameters, as with `--set`
    duration: float | None = None  # [s]; None: the duration of the scene
    label: ClassVar[str] = ""  # name in the progress bar
    of_pair: ClassVar[bool] = False  # whether it is stored with its scene and method
    as_planned: ClassVar[bool] = False  # whether the scene has the parameters of the study

    def posed(self) -> Scene:
        """The scene with the changed parameters and the duration; raises ParameterError."""
        scene = find_scene(self.scene)
        if self.changes:
            system = system_of(scene)
            changes = dict(self.changes)
            known(changes, system.parameters)
            scene = replace(scene, parameters=system.change(scene.parameters, changes))
        return scene if self.duration is None else replace(scene, duration=self.duration)

    def answer(self, method: Method, planned: Scene | None = None) -> Answer | None:
        """The answer by `method` on the scene `planned`, or else on the posed scene. None if the
        method's engine is missing, the method is not meant for the scene or does not support it, or
        the run diverged. Raises ParameterError."""
        scene = planned or self.posed()
        if not installed(engine_of(method)) or not meant(method, scene):
            return None
        try:
            return self.made(scene, method)
        except Unsupported:
            return None

    @abstractmethod
    def made(self, scene: Scene, method: Method) -> Answer | None:
        """Computes the answer on a scene by a method that is installed and meant for the scene."""

    def work(self, scene: Scene, method: Method) -> float:
        """The approximate number of steps of a pendulum that take as long."""
        return _SEARCH_WORK * system_of(scene).weight


def work_of(scene: Scene, method: Method, steps: Sequence[float]) -> float:
    """The approximate number of steps of a pendulum in C that take as long as runs with these
    steps."""
    if method.control == "tolerance":
        return _ADAPTIVE_WORK
    count = sum(scene.duration / h for h in steps)
    return count * system_of(scene).weight * (1.0 if method.engine == "mujoco" else 2.0)
