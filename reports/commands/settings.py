"""plumbob settings: what to paste into a model of your own, or how its settings differ."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import FileChecks, SettingsToPaste
from plumbob.engines.method import Method, time_step
from plumbob.engines.registry import engine_of, installed, method
from plumbob.reports.commands.arguments import values

CHECKED = "mujoco/euler+coulomb"  # what a file is held against unless a method is given


def command(chosen: argparse.Namespace) -> int:
    """Print settings, or the differences of a file from them."""
    if chosen.check is not None:
        return _check(chosen)
    if chosen.method is None:
        raise ParameterError("METHOD", None, "given, as `plumbob settings METHOD --step DT`")
    if chosen.step is None:
        raise ParameterError("step", None, "given, in seconds: settings are for one step")
    named = method(chosen.method)
    step = time_step("step", chosen.step)
    of_engine = engine_of(named).ability(SettingsToPaste)
    if of_engine is None or named.control != "step":
        raise ParameterError("method", named.name, "one of an engine with settings to paste")
    settings = of_engine.write(named, step, chosen.stiffness, chosen.friction)
    values.show(chosen, settings, "settings", of=settings)
    return 0


def _check(chosen: argparse.Namespace) -> int:
    for name in ("step", "stiffness"):
        if getattr(chosen, name) is not None:
            raise ParameterError(
                name, getattr(chosen, name), "left out: --check takes the file's"
            )
    named: Method = method(chosen.method or CHECKED)
    engine = engine_of(named)
    checks = engine.ability(FileChecks)
    if checks is None or not installed(engine):
        raise ParameterError("method", named.name, "one of an installed engine that reads MJCF")
    checked = checks.check(Path(chosen.check), named)
    width = max((len(field) for field, _, _ in checked.differences), default=0)
    values.show(chosen, checked, "check", file=chosen.check, checked=checked, width=width)
    return 1 if checked.warnings else 0
