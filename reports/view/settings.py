"""Settings to copy, as the page shows them: text of an adapter, which runs no engine for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from plumbob.engines.abilities import Settings
from plumbob.reports.advice.recommend import DEFAULT_METHOD

SHOWN = (  # methods, and what for
    ("mujoco/euler+coulomb", "A robot with contacts in MuJoCo"),
    ("mujoco/rk4", "A robot without contacts in MuJoCo"),
    ("pymunk/feet", "A body that slides in pymunk, seen from above"),
)


@dataclass(frozen=True)
class Pasted:
    """Settings of one method, under a title."""

    title: str
    settings: Settings


def pasted(settings: Mapping[str, Settings]) -> tuple[Pasted, ...]:
    """The settings to show of those that a study has, by method."""
    return tuple(to_copy(settings[name], title) for name, title in SHOWN if name in settings)


def to_copy(settings: Settings, title: str, cost: str = "") -> Pasted:
    """Settings under a title; a study's own `cost` of a step, in steps of MuJoCo's default method,
    takes the place of the usual one."""
    if cost:
        words = (
            f"{cost} times a step of {DEFAULT_METHOD}, the median over the scenes of this study"
        )
        snippets = tuple(replace(snippet, cost=words) for snippet in settings.snippets)
        settings = replace(settings, snippets=snippets)
    return Pasted(title, settings)
