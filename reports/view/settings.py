"""Settings of methods that a reader may copy from the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from plumbob.engines.abilities import Settings
from plumbob.reports.advice.recommend import DEFAULT_METHOD

SHOWN = (  # methods, each with the title of its settings
    ("mujoco/euler+coulomb", "A robot with contacts in MuJoCo"),
    ("mujoco/rk4", "A robot without contacts in MuJoCo"),
    ("pymunk/feet", "A body that slides in pymunk, seen from above"),
)


@dataclass(frozen=True)
class TitledSettings:
    """The settings of one method with a title."""

    title: str
    settings: Settings


def shown_settings(settings: Mapping[str, Settings]) -> tuple[TitledSettings, ...]:
    """Returns the settings that a study's page shows; `settings` are all settings of the study, by
    method."""
    return tuple(
        titled_settings(settings[name], title) for name, title in SHOWN if name in settings
    )


def titled_settings(settings: Settings, title: str, cost: str = "") -> TitledSettings:
    """Returns settings with a title. If the study measured the `cost` of a step, in multiples of a
    step of MuJoCo's default method, that cost replaces the usual one in the text."""
    if cost:
        words = (
            f"{cost} times a step of {DEFAULT_METHOD}, the median over the scenes of this study"
        )
        snippets = tuple(replace(snippet, cost=words) for snippet in settings.snippets)
        settings = replace(settings, snippets=snippets)
    return TitledSettings(title, settings)
