"""Observables that an engine is declared not to give: one that drops another fails, and so does one
that gives one of these after all."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.registry import limits_of
from plumbob.models.registry import find_system


def not_read(scene: str, method: str) -> Mapping[str, str]:
    """The observables of a scene that a method is declared not to give, each with the reason."""
    if not (reasons := limits_of(method).unread(scene, method)):
        return {}
    names = {o.name for o in find_system(scene.partition("/")[0]).observables}
    return {name: why for name, why in reasons.items() if name in names}
