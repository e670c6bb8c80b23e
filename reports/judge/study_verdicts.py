"""The verdicts on everything that a study measured, by scene and method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.results import Study
from plumbob.reports.judge.expectations import accurate, standing
from plumbob.reports.judge.verdict import Judged, StoredObservables, judged

Judgements = Mapping[tuple[str, str], Judged]  # by scene and method


def judge_study(study: Study, within: float | None = None) -> Judgements:
    """Returns the verdicts on everything that a study measured; each run is judged once. If
    `within` is given, a method whose finest run exceeds this relative error is `inaccurate`."""
    methods = {m.name: m for m in study.methods}
    observed = {s.name: StoredObservables(study.observables(s.name)) for s in study.scenes}
    verdicts = {}
    for c in study.convergence:
        result = judged(c, observed[c.scene], methods[c.method], study.quantities(c.scene))
        judgement = result.whole if within is None else accurate(result.whole, within)
        judgement = replace(judgement, versions=study.provenance.versions)
        verdicts[c.scene, c.method] = replace(result, whole=judgement)
    return verdicts


def unexpected(study: Study, judgements: Judgements) -> list[str]:
    """Returns "scene method" for each pair whose verdict is unexpected. A user's own method is
    unexpected if its errors are not as predicted."""
    return [
        f"{scene.name} {method.name}"
        for scene, method in product(study.scenes, study.methods)
        if (judged := judgements.get((scene.name, method.name)))
        and (
            standing(scene, method, judged.whole) == "unexpected"
            or (
                method.name == USER_METHOD
                and judged.whole.verdict not in ("predicted", "converges")
            )
        )
    ]
