"""The verdicts on everything that a study measured, by scene and method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.results import Study
from plumbob.reports.judge.expectations import require_accuracy, standing
from plumbob.reports.judge.verdict import JudgedMethod, StoredObservables, judge_method

Judgements = Mapping[tuple[str, str], JudgedMethod]  # by scene and method


def judge_study(study: Study, within: float | None = None) -> Judgements:
    """Returns the verdicts on everything that a study measured; each run is judged once. If
    `within` is given, a method whose finest run exceeds this relative error is `inaccurate`."""
    methods = {method.name: method for method in study.methods}
    observed = {s.name: StoredObservables(study.observables(s.name)) for s in study.scenes}
    verdicts = {}
    for runs in study.convergence:
        quantities = study.quantities(runs.scene)
        judged = judge_method(runs, observed[runs.scene], methods[runs.method], quantities)
        judgement = judged.whole
        if within is not None:
            judgement = require_accuracy(judgement, within)
        judgement = replace(judgement, versions=study.provenance.versions)
        verdicts[runs.scene, runs.method] = replace(judged, whole=judgement)
    return verdicts


def unexpected_pairs(study: Study, judgements: Judgements) -> list[str]:
    """Returns "scene method" for each pair whose verdict is unexpected. A user's own method is
    unexpected if its errors are not as predicted."""
    pairs = []
    for scene, method in product(study.scenes, study.methods):
        judged = judgements.get((scene.name, method.name))
        if judged is None:
            continue
        as_predicted = judged.whole.verdict in ("predicted", "converges")
        user_error = method.name == USER_METHOD and not as_predicted
        if user_error or standing(scene, method, judged.whole) == "unexpected":
            pairs.append(f"{scene.name} {method.name}")
    return pairs
