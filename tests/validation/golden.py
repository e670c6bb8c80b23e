"""Freeze what a profile measures into a file, and hold a later tree against it, to the last bit.

    python -m plumbob.tests.validation.golden freeze FILE [quick | hard]
    python -m plumbob.tests.validation.golden compare FILE [SCENES [METHODS]]

For a change that is to keep behaviour, on one machine: measured errors agree to the last bit, what
theory says of them to 1e-12, verdicts and numbers of steps exactly. `hard` are the hard scenes of
the full profile, with at most 100,000 steps a run.
"""

import gzip
import json
import math
import sys
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path

from plumbob.engines.method import meant
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.runner import most_steps
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.expectations import as_expected
from plumbob.reports.judge.verdict import judge_method

RELATIVE = 1e-12  # sums may be reordered
EXACT = ("largest", "end", "scale", "steps", "diverged_at")
MOST_STEPS = 100_000  # of a hard scene's run


def freeze(profile):
    """Yield a record of every pair of scene and method of the profile."""
    chosen = scenes(profile="quick") if profile == "quick" else scenes()
    for scene in chosen:
        for method in methods():
            if meant(method, scene) and (profile == "quick" or scene.hard):
                yield record(scene, method, profile)


def record(scene, method, profile):
    """What one method measures on one scene, with its verdicts, as plain data."""
    system = system_of(scene)
    most = most_steps(scene, "quick") if profile == "quick" else int(MOST_STEPS / system.weight)
    found = convergence_study(scene, method, most)
    verdicts = judge_method(found, system, method, system.quantities(case_of(scene)))
    runs = []
    for run, verdict in zip(found.measurements, verdicts.runs, strict=True):
        bounds = {name: [held.bound] for name, held in verdict.tolerances.items()}
        runs.append({**plain(run), "verdict": verdict.verdict, "tolerances": bounds})
    return {
        "scene": scene.name,
        "method": method.name,
        "profile": profile,
        "verdict": verdicts.whole.verdict,
        "expected": bool(as_expected(scene, method, verdicts.whole)),
        "cut": found.cut,
        "runs": runs,
    }


def plain(value):
    """Dataclasses, mappings and numpy numbers as plain data."""
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, Mapping):
        return {str(name): plain(entry) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return value.item() if hasattr(value, "item") else value


def differences(old, new, path=""):
    """Yield where two records differ by more than is allowed; what only `new` has is passed over,
    and so are times of the wall clock and names of reasons."""
    name = path.rpartition(".")[2]
    if name in ("model", "why", "reason", "seconds", "compile_seconds", "warnings", "profile"):
        if name == "model":  # {reason: bound}: reasons may be renamed
            yield from differences(sorted(old.values()), sorted(new.values()), f"{path}.bounds")
    elif isinstance(old, dict) and isinstance(new, dict):
        for key, value in old.items():
            if key in new:
                yield from differences(value, new[key], f"{path}.{key}")
    elif isinstance(old, list) and isinstance(new, list):
        if name != "bounds" and path.endswith("tolerances"):
            old = old[:1]
            new = new[:1]
        if len(old) != len(new):
            yield f"{path}: {len(old)} entries, now {len(new)}"
        for i, pair in enumerate(zip(old, new, strict=False)):
            yield from differences(*pair, f"{path}[{i}]")
    elif not same(old, new, RELATIVE if name not in EXACT else 0.0):
        yield f"{path}: {old!r}, now {new!r}"


def same(old, new, relative):
    """Whether two values are equal, or numbers that agree to `relative`."""
    if old == new:
        return True
    if not all(isinstance(value, float) for value in (old, new)):
        return False
    return math.isclose(old, new, rel_tol=relative) or (math.isnan(old) and math.isnan(new))


def compare(pairs, of_scenes, of_methods, profile):
    """Print every pair that differs; returns how many do."""
    differ = count = 0
    for old in pairs:
        if not (
            fnmatchcase(old["scene"], of_scenes) and fnmatchcase(old["method"], of_methods)
        ):
            continue
        new = record(find_scene(old["scene"]), find_method(old["method"]), profile)
        found = list(differences(_first_bounds(old), new))
        count = count + 1
        if found:
            differ += 1
            print(
                f"{old['scene']} {old['method']}: {len(found)} differ", *found[:5], sep="\n   "
            )
    print(f"{count} pairs, {differ} differ")
    return differ


def _first_bounds(old):
    """A record whose tolerances are bounds alone: their terms have names that may change."""
    runs = [
        {**run, "tolerances": {name: held[:1] for name, held in run["tolerances"].items()}}
        for run in old["runs"]
    ]
    return {**old, "runs": runs}


def main(arguments):
    """Freeze or compare; returns an exit code."""
    kind, file, *rest = arguments
    opened = gzip.open
    if kind == "freeze":
        profile = rest[0] if rest else "quick"
        with opened(Path(file), "wt") as stream:
            json.dump({"profile": profile, "pairs": list(freeze(profile))}, stream)
        return 0
    with opened(Path(file), "rt") as stream:
        frozen = json.load(stream)
    of_scenes, of_methods = [*rest, "*", "*"][:2]
    profile = frozen.get("profile", "hard" if "hard" in Path(file).name else "quick")
    return int(compare(frozen["pairs"], of_scenes, of_methods, profile) > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
