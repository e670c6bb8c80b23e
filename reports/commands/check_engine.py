"""plumbob check-engine: whether an engine's adapter does what plumbob expects of it."""

from __future__ import annotations

import argparse
import sys

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.engine_check import CheckOutcome, check_engine

MISSING = 3


def command(chosen: argparse.Namespace) -> int:
    """Print one line a check as it is made; returns 1 where one fails, 3 where the engine's package
    is not installed."""
    methods = find_methods(chosen.name)
    scenes = find_scenes(chosen.scenes, "quick")
    for method in methods:
        if not installed(engine := engine_of(method)):
            print(f"plumbob: {engine.package} is missing", file=sys.stderr)
            return MISSING
    if not any(meant(method, scene) for method in methods for scene in scenes):
        raise ParameterError("scenes", chosen.scenes, f"some that {chosen.name} is meant for")
    done: list[CheckOutcome] = []
    for checked in check_engine(methods, scenes):
        done.append(checked)
        if not chosen.json:
            line = f"{checked.status:<11}  {checked.name:<20}  {checked.detail}"
            print(line, flush=True)
    if chosen.json:
        values.print_json(done)
    return int(any(checked.status == "fail" for checked in done))
