"""plumbob solve: the exact answer of a scene, without any engine."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.commands import values


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="system/case, or a system's default case")
    values.add_changes(parser)
    parser.add_argument("--times", metavar="T,T,...", help="times [s]; default: 11 over the scene")
    parser.add_argument("--json", action="store_true", help="print JSON, with every digit")


def command(chosen: argparse.Namespace) -> int:
    """Print the observables at the times wanted, and what else is exact."""
    scene = find_scene(chosen.scene, values.changes(chosen.changes))
    times = values.times(chosen.times) if chosen.times else np.linspace(0, scene.duration, 11)
    case = case_of(scene)
    answer: dict[str, Any] = {
        "scene": scene.name,
        "parameters": scene.parameters,
        "times": times,
        "observables": case.reference.observe(times),
        **case.system.facts(case.problem),
    }
    if chosen.json:
        json.dump(values.plain(answer), sys.stdout, indent=1)
        print()
        return 0
    print(f"{scene.name}: {scene.summary}")
    _print({key: answer[key] for key in answer if key not in ("scene", "times", "observables")})
    names = list(answer["observables"])
    units = {o.name: o.unit for o in case.system.observables}
    print(f"\n{'t [s]':>24}" + "".join(_head(n, units) for n in names))
    for i, t in enumerate(times):
        row = (_text(float(answer["observables"][name][i])) for name in names)
        print(f"{_text(float(t)):>24}" + "".join(f"{text:>26}" for text in row))
    return 0


def _print(entries: Mapping[str, Any], indent: int = 2) -> None:
    for key, value in entries.items():
        if isinstance(value, Mapping):
            print(f"{' ' * indent}{key}:")
            _print(value, indent + 2)
        elif isinstance(value, (list, tuple)) and value and isinstance(value[0], Mapping):
            print(f"{' ' * indent}{key}:")
            for entry in value:
                print(" " * (indent + 2) + ", ".join(f"{k} {_text(v)}" for k, v in entry.items()))
        elif value is not None and value != "":
            print(f"{' ' * indent}{key}: {_text(value)}")


def _text(value: Any) -> str:
    return repr(float(value) + 0.0) if isinstance(value, float) else str(value)  # no -0.0


def _head(name: str, units: Mapping[str, str]) -> str:
    return f"{name} [{units.get(name, '')}]".rjust(26)
