"""An audit as text and as a page: the answer, the figures and the tables that its template
writes."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.contacts import ContactAudit
from plumbob.engines.audit.holds import LONG_CREEP, SHORT_CREEP, HoldsAudit
from plumbob.engines.difference.repetitions import RepeatedMotion
from plumbob.reports.advice.audit_advice import AuditAdvice, audit_advice, halving
from plumbob.reports.advice.audit_summary import audit_summary
from plumbob.reports.advice.creep_options import options_text
from plumbob.reports.records.page_records import Replay
from plumbob.reports.view.audit.contacts import contact_numbers
from plumbob.reports.view.audit.html import AuditPage, AuditReport, Tile
from plumbob.reports.view.audit.motion import motion_numbers
from plumbob.reports.view.content import Cell, Finding
from plumbob.reports.view.finding_text import read_findings as worded
from plumbob.reports.view.tables import table_or_none
from plumbob.reports.view.tables import terminal_lines as text_lines

AnyAudit = Audit | ContactAudit | HoldsAudit | RepeatedMotion
MOST_LINES = 8  # largest number of lines of an audit on the terminal, unless all are asked for


def audit_report(audit: Audit) -> AuditReport:
    """Returns the first part of the page of an audit."""
    advice = audit_advice(audit)
    halved = halving(audit) if audit.found else None
    summary = audit_summary(audit, advice, halved)
    warnings = text_lines("audit_warnings", advice=advice)
    numbers = {"audit": audit, "advice": advice, "halving": halved, "summary": summary}
    texts = text_lines("audit_tiles", warnings=warnings, **numbers)
    tiles = [
        Tile(question, grade, text)
        for (question, grade), text in zip(summary.grades, texts, strict=True)
    ]
    return AuditReport(
        headline=" ".join(text_lines("audit_headline", audit=audit)),
        tiles=tuple(tiles),
        warnings=tuple(warnings),
        advised=tuple(text_lines("audit_fixes", **numbers)),
        fixes=table_or_none("audit_fixes", **numbers),
    )


def holds_snippet(audit: HoldsAudit) -> str:
    """Returns the options to paste that stop the creep of an audit; empty if there are none."""
    remedy = audit.remedy
    return options_text(audit.model.options, remedy.options) if remedy else ""


def audit_answer(audit: AnyAudit) -> Finding:
    """Returns the finding that the template writes of an audit. Its first table is the answer; its
    other tables and figures are for the page."""
    numbers: dict[str, Any] = {"audit": audit, "file": Path(audit.name).name}
    if isinstance(audit, ContactAudit):
        (finding,) = worded("audit/contacts", numbers | contact_numbers(audit))
    elif isinstance(audit, HoldsAudit):
        numbers |= {
            "snippet": holds_snippet(audit),
            "short": SHORT_CREEP,
            "long": LONG_CREEP,
            "infinite": math.inf,
        }
        (finding,) = worded("audit/holds", numbers)
    elif isinstance(audit, RepeatedMotion):
        (finding,) = worded("audit/reproducible", numbers)
    else:
        advice = audit_advice(audit)
        numbers |= {"advice": advice, "to_do": to_do_text(audit, advice)}
        numbers["halving"] = halving(audit) if audit.found else None
        (finding,) = worded("audit/motion", {**numbers, "motion": motion_numbers(audit)})
    return finding


def to_do_text(audit: Audit, advice: AuditAdvice) -> str:
    """Returns the advice of an audit as one line of text, with its warnings."""
    return _to_do(audit, advice, text_lines("audit_warnings", advice=advice))


def _to_do(audit: Audit, advice: AuditAdvice, warnings: Sequence[str]) -> str:
    """Returns the advice of an audit and these warnings as one line of text."""
    about = {"control": audit.control, "format": audit.model.format}
    return " ".join(text_lines("audit_to_do", advice=advice, warnings=warnings, **about))


def answer_rows(answer: Finding) -> list[tuple[str, str]]:
    """Returns the rows of an answer, the first table of the finding: (name, text)."""
    return [(name.text, text.text) for name, text in answer.tables[0].rows]


def answer_lines(answer: Finding) -> list[str]:
    """Returns the rows of an answer as lines of text, with the texts aligned in a column."""
    indent = _indent(answer)
    return [f"{name:{indent}}{text}" for name, text in answer_rows(answer)]


def _indent(answer: Finding) -> int:
    """Returns the column at which the texts of an answer's lines begin."""
    return max(len(name) for name, _ in answer_rows(answer)) + 2


def short_lines(audit: Audit, width: int) -> list[str]:
    """Returns the answer for a terminal of `width` columns: what is wrong, what to do, then what
    else matters. These are at most MOST_LINES lines, which end at words; texts that do not fit are
    left out, and the last line says how many. The first line is the first of `answer_lines`."""
    answer = audit_answer(audit)
    indent = _indent(answer)
    lines = [answer_lines(answer)[0]]
    left_out = 0
    for name, text in _short_rows(audit):
        wrapped = textwrap.wrap(
            f"{name:{indent}}{text}",
            width,
            subsequent_indent=" " * indent,
            break_long_words=False,
            break_on_hyphens=False,
        )
        fits = not left_out and len(lines) + len(wrapped) < MOST_LINES
        lines += wrapped if fits else []
        left_out += not fits
    more = f"--verbose: {left_out} more, and all numbers" if left_out else "--verbose"
    return [*lines, f"{'all lines':{indent}}{more}"]


def _short_rows(audit: Audit) -> list[tuple[str, str]]:
    """Returns the rows of the short answer, the most important first: (name, text). A step that is
    unstable comes before its error."""
    report = audit_report(audit)
    fixes = report.advised or (_to_do(audit, audit_advice(audit), ()),)
    known = [tile for tile in report.tiles[1:3] if tile.grade != "unknown"]
    unstable = [tile for tile in known if (tile.question, tile.grade) == ("stability", "bad")]
    others = [tile for tile in known if tile not in unstable]
    return [
        *((tile.question, tile.text) for tile in unstable),
        ("error", report.headline),
        *(("to do", fix) for fix in fixes),
        *(("warning", warning) for warning in report.warnings),
        *((tile.question, tile.text) for tile in others),
    ]


def audit_page(
    answer: Finding,
    audit: AnyAudit,
    command: str,
    replay: Replay | None = None,
) -> AuditPage:
    """Returns the content of the page of an audit, whose first table has lines that wrap. `command`
    repeats the audit; `replay` shows its motion."""
    table = answer.tables[0]
    text_rows = tuple((name, Cell(text.text, "text")) for name, text in table.rows)
    return AuditPage(
        finding=replace(answer, tables=(replace(table, rows=text_rows), *answer.tables[1:])),
        command=command,
        lasted=audit.seconds,
        versions=package_versions(),
        replay=replay,
        code=code_to_paste(audit),
        report=audit_report(audit) if isinstance(audit, Audit) else None,
        card=tuple(card_lines(audit)) if isinstance(audit, Audit) else (),
    )


def code_to_paste(audit: AnyAudit) -> str:
    """Returns the lines of MJCF that an audit of contacts advises; empty if there are none."""
    if isinstance(audit, (Audit, RepeatedMotion)):
        return ""
    return audit.snippet if isinstance(audit, ContactAudit) else holds_snippet(audit)


def card_lines(audit: Audit) -> list[str]:
    """Returns the answer as a card: a line with the error, how well it is known and the recommended
    choice; then the lines to put into the model file."""
    return text_lines("audit_card", audit=audit, advice=audit_advice(audit))


def package_versions() -> dict[str, str]:
    """Returns the versions of the packages that compute the numbers of an audit, by name."""
    return {name: metadata.version(name) for name in ("mujoco", "numpy", "scipy")}
