"""plumbob settings: settings to paste into your own model, or how a file differs from them."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import FileChecks, SettingsToPaste
from plumbob.engines.method import time_step
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values

DEFAULT_METHOD = "mujoco/euler+coulomb"  # method with which a file is compared by default


def command(chosen: argparse.Namespace) -> int:
    """Prints the settings of a method to paste into a model, or how a file differs from them.
    Returns 1 if contacts of the file do not fit its time step."""
    if chosen.check is not None:
        return _check_file(chosen)
    if chosen.method is None:
        raise ParameterError("METHOD", None, "given, as `plumbob settings METHOD --step DT`")
    if chosen.step is None:
        raise ParameterError("step", None, "given, in seconds: settings are for one step")
    method = find_method(chosen.method)
    step = time_step("step", chosen.step)
    writer = engine_of(method).ability(SettingsToPaste)
    if writer is None or method.control != "step":
        raise ParameterError("method", method.name, "one of an engine with settings to paste")
    settings = writer.write(method, step, chosen.stiffness, chosen.friction)
    values.show(chosen, settings, "settings", settings=settings)
    return 0


def _check_file(chosen: argparse.Namespace) -> int:
    """Prints how the file --check differs from the settings of a method. Returns 1 if the contacts
    of the file do not fit its time step."""
    for name in ("step", "stiffness"):
        value = getattr(chosen, name)
        if value is not None:
            raise ParameterError(name, value, "left out: --check takes the file's")
    method = find_method(chosen.method or DEFAULT_METHOD)
    engine = engine_of(method)
    checker = engine.ability(FileChecks)
    if checker is None or not installed(engine):
        raise ParameterError(
            "method", method.name, "one of an installed engine that reads MJCF"
        )
    checked = checker.check(Path(chosen.check), method)
    width = max((len(field) for field, _, _ in checked.differences), default=0)
    values.show(chosen, checked, "check", file=chosen.check, checked=checked, width=width)
    return 1 if checked.warnings else 0
