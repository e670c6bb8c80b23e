"""Settings to copy, as the page shows them: text of an adapter, which runs no engine for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from plumbob.engines.abilities import Settings, SettingsToPaste, Snippet
from plumbob.engines.registry import engine_of, method
from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import DEFAULT_METHOD

SHOWN = (  # methods, what for, and the step [s] to write the settings for
    ("mujoco/euler+coulomb", "A robot with contacts in MuJoCo", 1e-3),
    ("mujoco/rk4", "A robot without contacts in MuJoCo", 1e-3),
    ("pymunk/feet", "A body that slides in pymunk, seen from above", 1e-3),
)
FRICTION = 0.3  # coefficient in the text, as `plumbob settings` has it by default


@dataclass(frozen=True)
class Pasted:
    """Settings of one method, under a title, with the command that prints them."""

    title: str
    command: str
    settings: Settings

    def codes(self, snippet: Snippet) -> Iterator[tuple[str, str]]:
        """Kind and text of each part of a snippet: where it goes differs."""
        if snippet.mjcf:
            yield "MJCF", snippet.mjcf
        if snippet.python:
            yield "Python", snippet.python


def pasted(study: Study) -> tuple[Pasted, ...]:
    """The settings to show for the engines that are in the study."""
    engines = {m.engine for m in study.methods}
    return tuple(
        written_for(name, step, title) for name, title, step in SHOWN if _writes(name, engines)
    )


def written_for(name: str, step: float, title: str, cost: str = "") -> Pasted:
    """The settings of a method, of an engine that writes some, at a step [s]; a study's own `cost`
    of a step, in steps of MuJoCo's default method, takes the place of the usual one."""
    chosen = method(name)
    settings_of = engine_of(chosen).ability(SettingsToPaste)
    assert settings_of is not None, name
    command = f"plumbob settings {name} --step {step:g}"
    settings = settings_of.write(chosen, step, None, FRICTION)
    if cost:
        words = f"{cost} times a step of {DEFAULT_METHOD}, the median over the scenes of this study"
        snippets = tuple(replace(snippet, cost=words) for snippet in settings.snippets)
        settings = replace(settings, snippets=snippets)
    return Pasted(title, command, settings)


def _writes(name: str, engines: set[str]) -> bool:
    chosen = method(name)
    return chosen.engine in engines and engine_of(chosen).ability(SettingsToPaste) is not None
