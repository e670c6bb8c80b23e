"""Runs that a page's sections make for themselves, beside those of the study."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbob.engines.method import Method
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene


def run(
    name: str, method: str | Method, step: float, duration: float | None = None, **changes: Any
) -> Trajectory | None:
    """Run a scene, for `duration` [s] where that is given, with parameters changed; None where the
    engine is missing, or the run does not reach the end."""
    chosen = find_scene(name, changes)
    how = find_method(method) if isinstance(method, str) else method
    if duration is not None:
        chosen = replace(chosen, duration=duration)
    if not installed(engine_of(how)):
        return None
    found = engine_of(how).prepare(case_of(chosen), how, step).run()
    return found if found.diverged_at is None else None
