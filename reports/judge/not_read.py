"""Observables that an engine is declared not to give. A run that lacks any other observable fails.
A run that does give a declared one fails too."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.registry import limits_of
from plumbob.models.registry import find_system


def not_read(scene: str, method: str) -> Mapping[str, str]:
    """Returns {observable: reason} for the observables of a scene that a method is declared not to
    give."""
    reasons = limits_of(method).unread(scene, method)
    if not reasons:
        return {}
    names = {o.name for o in find_system(scene.partition("/")[0]).observables}
    return {name: reason for name, reason in reasons.items() if name in names}
