"""The findings and galleries of a study, written by the templates from the stored numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from plumbob.engines.study.results import Analysed, Study
from plumbob.reports.view.content import Finding
from plumbob.reports.view.finding_text import findings_of, read_findings

NOT_SHOWN = "not shown"


def findings_about(study: Study, of: str, place: str = "finding") -> tuple[Finding, ...]:
    """Returns the findings of one system, or of "engines"; with `place` "gallery", its galleries.

    If unexpected verdicts rule an analysis out, one finding names the pairs with these verdicts.
    If a template needs a number that the study does not store, one finding lists such templates."""
    from jinja2 import UndefinedError

    findings = list[Finding]()
    failed = list[Analysed]()
    incomplete = list[str]()  # templates that need numbers which are not stored
    for analysis in study.analyses:
        if (analysis.system, analysis.place) != (of, place):
            continue
        if analysis.numbers is None:
            failed.append(analysis)
            continue
        try:
            findings += findings_of(analysis)
        except UndefinedError as error:
            incomplete.append(f"{analysis.template} ({error.message})")
    notes = list[Finding]()
    if failed:
        pairs = [pair for pair, _ in failed[0].claims]
        notes += read_findings(
            "pages/left_out", {"of": of, "count": len(failed), "pairs": pairs}
        )
    if incomplete:
        notes += read_findings("pages/older_store", {"of": of, "templates": incomplete})
    return (*checked_findings(findings), *notes)


def checked_findings(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Returns the findings, each replaced by a "not shown" finding if one of its claims fails. The
    replacement lists the claims that failed and judges no statement of a source."""
    return tuple(_or_not_shown(finding) for finding in findings)


def _or_not_shown(finding: Finding) -> Finding:
    """Returns the finding if all its claims hold, else its "not shown" replacement."""
    failed = [claim.text for claim in finding.claims if not claim.holds]
    if not failed:
        return finding
    (not_shown,) = read_findings("pages/not_shown", {"title": finding.title, "missed": failed})
    return replace(
        finding,
        title=not_shown.title,
        judgement=not_shown.judgement,
        summary=not_shown.summary,
        statements=(),
    )
