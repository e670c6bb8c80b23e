"""plumbob settings: what to paste into a model of your own, or how its settings differ."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from textwrap import fill, indent

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import FileChecks, Settings, SettingsToPaste
from plumbob.engines.method import Method, time_step
from plumbob.engines.registry import engine_of, installed, method
from plumbob.reports.commands.arguments import values
from plumbob.reports.view.tables import lines

CHECKED = "mujoco/euler+coulomb"  # what a file is held against unless a method is given


def command(chosen: argparse.Namespace) -> int:
    """Print settings, or the differences of a file from them."""
    if chosen.check is not None:
        return _check(chosen)
    if chosen.method is None:
        raise ParameterError("METHOD", None, "given, as `plumbob settings METHOD --step DT`")
    if chosen.step is None:
        raise ParameterError("step", None, "given, in seconds: settings are for one step")
    named, step = method(chosen.method), time_step("step", values.number("step", chosen.step))
    of_engine = engine_of(named).ability(SettingsToPaste)
    if of_engine is None or named.control != "step":
        raise ParameterError("method", named.name, "one of an engine with settings to paste")
    stiffness = (
        None if chosen.stiffness is None else values.positive_number("stiffness", chosen.stiffness)
    )
    friction = values.positive_number("friction", chosen.friction)
    settings = of_engine.write(named, step, stiffness, friction)
    if chosen.json:
        values.print_json(asdict(settings))
    else:
        print(_text(settings))
    return 0


def _text(settings: Settings) -> str:
    parts = [f"{settings.method} at {settings.step:g} s, to paste into a model of your own"]
    shown: set[str] = set()
    for snippet in settings.snippets:
        code = "\n\n".join(filter(None, (snippet.mjcf, snippet.python)))
        notes = [
            fill(f"{word:<7}{text}", 98, initial_indent="  ", subsequent_indent=" " * 9)
            for word, text in (
                ("error", snippet.error),
                ("cost", snippet.cost),
                ("holds", snippet.holds),
            )
            if text not in shown
        ]
        shown |= {snippet.cost, snippet.holds}
        parts.append("\n".join((f"{snippet.title}:\n", indent(code, "    "), "", *notes)))
    return "\n\n".join(parts)


def _check(chosen: argparse.Namespace) -> int:
    for name in ("step", "stiffness"):
        if getattr(chosen, name) is not None:
            raise ParameterError(name, getattr(chosen, name), "left out: --check takes the file's")
    named: Method = method(chosen.method or CHECKED)
    engine = engine_of(named)
    checks = engine.ability(FileChecks)
    if checks is None or not installed(engine):
        raise ParameterError("method", named.name, "one of an installed engine that reads MJCF")
    checked = checks.check(Path(chosen.check), named)
    if chosen.json:
        values.print_json(asdict(checked))
    else:
        width = max((len(field) for field, _, _ in checked.differences), default=0)
        print(*lines("check", file=chosen.check, checked=checked, width=width), sep="\n")
    return 1 if checked.warnings else 0
