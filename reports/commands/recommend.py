"""plumbob recommend: the cheapest method and step for an error, from measurement."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.engines.method import Method
from plumbob.engines.study import store
from plumbob.engines.study.provenance import changed_since
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.reports.commands import values
from plumbob.reports.judge.recommend import Choice, Recommendation, cheapest

if TYPE_CHECKING:
    from plumbob.reports.judge.user_settings import UserResult
    from plumbob.reports.judge.verdict import Judgements


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="system/case, or a system's default case")
    parser.add_argument("--error", required=True, metavar="X", help="wanted, in SI units")
    parser.add_argument(
        "--out", metavar="DIR", default="plumbob-out", help="where `validate` stored its studies"
    )
    parser.add_argument(
        "--like", metavar="FILE", help="what the options of your own MJCF file give beside it"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def command(chosen: argparse.Namespace) -> int:
    """Answer from the newest stored study of the scene; measure it first where there is none."""
    error = values.positive_number("error", chosen.error)
    own = _own(chosen.like) if chosen.like else None
    name, file = chosen.scene, Path(chosen.out) / store.FILE
    # As it was typed first: to know every scene takes longer than to answer.
    study = store.load(file, scene=name)
    if study is None:
        name = find_scene(name).name
        study = store.load(file, scene=name) or _measured(name)
    if own is not None:
        study = _with_own(study, name, own)
    judged = _judged(study)
    found = cheapest(study, name, error, judged)
    if chosen.json:
        study_of = {"date": study.provenance.date, "versions": study.provenance.versions}
        answer = asdict(found) | {"study": study_of}
        answer |= {"user_settings": _user_settings(study, judged)} if chosen.like else {}
        json.dump(values.plain(answer), sys.stdout, indent=1)
        print()
    else:
        _print(found)
        print(f"  measured   {_measured_when(study)}")
        if chosen.like:
            from plumbob.reports.view.user_settings import lines

            print(*lines(_own_settings(study, judged)), sep="\n")
    if changed := changed_since(study.provenance):
        print(
            f"plumbob: measured with other versions: {'; '.join(changed)}; "
            f"run `plumbob validate --scenes {name}` again",
            file=sys.stderr,
        )
    return 0 if found.choice else 1


def _measured_when(study: Study) -> str:
    """Date and engine versions of a study, for a reader to doubt."""
    names = dict.fromkeys(method.engine for method in study.methods)
    versions = [f"{n} {v}" for n in names if (v := study.provenance.versions.get(n))]
    return ", ".join([study.provenance.date or "now", *versions])


def _judged(study: Study) -> Judgements:
    from plumbob.reports.judge.verdict import judge_study

    return judge_study(study)


def _measured(name: str) -> Study:
    from plumbob.engines.registry import methods as find_methods
    from plumbob.engines.study.runner import run_study

    print(f"no stored study of {name}: measuring it", file=sys.stderr)
    return run_study([find_scene(name)], find_methods("*"))


def _own(path: str) -> Method:
    from plumbob.reports.commands.like import own_method

    return own_method(path)


def _with_own(study: Study, name: str, own: Method) -> Study:
    """The study with the user's own settings, measured now."""
    from plumbob.engines.study.runner import joined, run_study

    return joined(study, run_study([find_scene(name)], [own], study.profile))


def _own_settings(study: Study, judged: Judgements) -> tuple[UserResult, ...]:
    from plumbob.reports.judge.user_settings import user_results

    return user_results(study, judged)


def _user_settings(study: Study, judged: Judgements) -> list[dict[str, Any]]:
    return [
        {name: value for name, value in asdict(found).items() if name != "judgement"}
        | {"verdict": found.judgement.verdict}
        for found in _own_settings(study, judged)
    ]


def _print(found: Recommendation) -> None:
    print(f"{found.scene}, {found.observable} within {found.error:g} {found.unit}:")
    if found.choice is None:
        print("  nothing that was measured reaches it")
        if found.best is not None:
            print(f"  the best: {_text(found.best, found.unit)}")
    else:
        print(f"  use        {_text(found.choice, found.unit)}")
        if found.runner_up is not None:
            print(f"  runner-up  {_text(found.runner_up, found.unit)}")
        for choice in found.by_engine:
            if choice not in (found.choice, found.runner_up):
                engine = f"in {choice.method.partition('/')[0]}"
                print(f"  {engine:<10} {_text(choice, found.unit)}")
    for choice in found.defaults:
        print(f"  at 0.002 s {_text(choice, found.unit)}")


def _text(choice: Choice, unit: str) -> str:
    word = "rtol" if choice.control == "tolerance" else "step"
    tail = "" if word == "rtol" else " s"
    return (
        f"{choice.method:<22} {word} {choice.step:g}{tail}: error {choice.error:.2g} {unit}, "
        f"{choice.ns_per_second / 1e6:.3g} ms per simulated second"
    )
