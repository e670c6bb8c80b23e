"""plumbob check-engine: check that an engine's adapter does what plumbob expects."""

from __future__ import annotations

import argparse
import sys
from itertools import product

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.engine_check import CheckOutcome, check_engine

MISSING = 3


def command(chosen: argparse.Namespace) -> int:
    """Prints one line for each check as soon as it is made. Returns 1 if a check fails, 3 if the
    engine's package is not installed, else 0."""
    methods = find_methods(chosen.name)
    scenes = find_scenes(chosen.scenes, "quick")
    for method in methods:
        engine = engine_of(method)
        if not installed(engine):
            print(f"plumbob: {engine.package} is missing", file=sys.stderr)
            return MISSING
    pairs = product(methods, scenes)
    if not any(meant(method, scene) for method, scene in pairs):
        raise ParameterError("scenes", chosen.scenes, f"some that {chosen.name} is meant for")
    outcomes: list[CheckOutcome] = []
    for outcome in check_engine(methods, scenes):
        outcomes.append(outcome)
        if not chosen.json:
            line = f"{outcome.status:<11}  {outcome.name:<20}  {outcome.detail}"
            print(line, flush=True)
    if chosen.json:
        values.print_json(outcomes)
    failed = any(outcome.status == "fail" for outcome in outcomes)
    return 1 if failed else 0
