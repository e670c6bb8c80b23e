"""The findings and galleries of a study, written by the templates from the stored numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from plumbob.engines.study.results import Analysed, Study
from plumbob.reports.view.content import Finding
from plumbob.reports.view.finding_text import findings_of, written

NOT_SHOWN = "not shown"


def formed(study: Study, of: str, place: str = "finding") -> tuple[Finding, ...]:
    """Returns the findings of one system, or of "engines"; with `place` "gallery", its galleries.

    If unexpected verdicts rule an analysis out, one finding names the pairs with these verdicts.
    If a template needs a number that the study does not store, one finding lists such templates."""
    from jinja2 import UndefinedError

    shown = list[Finding]()
    failed = list[Analysed]()
    older = list[str]()
    for analysis in study.analyses:
        if (analysis.system, analysis.place) != (of, place):
            continue
        if analysis.numbers is None:
            failed.append(analysis)
            continue
        try:
            shown += findings_of(analysis)
        except UndefinedError as error:
            older.append(f"{analysis.template} ({error.message})")
    lost = list[Finding]()
    if failed:
        pairs = [pair for pair, _ in failed[0].claims]
        lost += written("pages/left_out", {"of": of, "count": len(failed), "pairs": pairs})
    if older:
        lost += written("pages/older_store", {"of": of, "templates": older})
    return (*as_measured(shown), *lost)


def as_measured(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Returns the findings, each replaced by a "not shown" finding if one of its claims fails. The
    replacement lists the claims that failed and judges no statement of a source."""
    return tuple(_as_measured(finding) for finding in findings)


def _as_measured(finding: Finding) -> Finding:
    missed = [claim.text for claim in finding.claims if not claim.holds]
    if not missed:
        return finding
    (words,) = written("pages/not_shown", {"title": finding.title, "missed": missed})
    return replace(
        finding,
        title=words.title,
        judgement=words.judgement,
        summary=words.summary,
        statements=(),
    )
