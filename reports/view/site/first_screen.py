"""Counts of runs and verdicts, and the key findings, on the index."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from plumbob.reports.view.content import Finding
from plumbob.reports.view.method_results import Results
from plumbob.reports.view.site.claims import NOT_SHOWN

MOST_FINDINGS = 4


def meanings_by_engine(all_results: Results) -> Mapping[str, Counter[str]]:
    """Counts of meanings ("predicted", "converges", …) over the pairs of scene and method, for each
    engine that ran."""
    engines: dict[str, Counter[str]] = {}
    for result in all_results.values():
        if result.meaning != "not-run":
            engines.setdefault(result.method.engine, Counter())[result.meaning] += 1
    return engines


def run_counts(all_results: Results) -> tuple[int, int, int]:
    """Numbers of runs, of scenes and of methods that ran."""
    results = [result for result in all_results.values() if result.errors]
    scenes = {result.scene.name for result in results}
    methods = {result.name for result in results}
    return sum(len(result.errors) for result in results), len(scenes), len(methods)


def key_findings(findings: Sequence[Finding]) -> Sequence[Finding]:
    """At most `MOST_FINDINGS` findings with a figure, the key findings first. Other findings
    replace the key findings that the study lacks or does not show."""
    shown = [f for f in findings if f.judgement != NOT_SHOWN and f.figures]
    keys = sorted((f for f in shown if f.key), key=lambda finding: finding.key)
    return [*keys, *(f for f in shown if not f.key)][:MOST_FINDINGS]
