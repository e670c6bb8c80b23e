"""An audit as text and as a page: the answer, the figures and the tables that its template
writes."""

from __future__ import annotations

from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.contacts import ContactAudit
from plumbob.reports.advice.audit_advice import AuditAdvice, audit_advice, halving
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import Replay
from plumbob.reports.view.audit.contacts import contact_numbers
from plumbob.reports.view.audit.motion import motion_numbers
from plumbob.reports.view.content import Cell, Finding
from plumbob.reports.view.finding_text import read_findings as worded
from plumbob.reports.view.page import fill_page
from plumbob.reports.view.tables import terminal_lines as text_lines


def audit_answer(audit: Audit | ContactAudit) -> Finding:
    """Returns the finding that the template writes of an audit. Its first table is the answer; its
    other tables and figures are for the page."""
    numbers: dict[str, Any] = {"audit": audit, "file": Path(audit.name).name}
    if isinstance(audit, ContactAudit):
        (finding,) = worded("audit/contacts", numbers | contact_numbers(audit))
    else:
        advice = audit_advice(audit)
        numbers |= {"advice": advice, "to_do": to_do_text(audit, advice)}
        numbers["halving"] = halving(audit) if audit.found else None
        (finding,) = worded("audit/motion", {**numbers, "motion": motion_numbers(audit)})
    return finding


def to_do_text(audit: Audit, advice: AuditAdvice) -> str:
    """Returns the advice of an audit as one line of text."""
    about = {"control": audit.control, "format": audit.model.format}
    return " ".join(text_lines("audit_to_do", advice=advice, **about))


def answer_rows(answer: Finding) -> list[tuple[str, str]]:
    """Returns the rows of an answer, the first table of the finding: (name, text)."""
    return [(name.text, text.text) for name, text in answer.tables[0].rows]


def answer_lines(answer: Finding) -> list[str]:
    """Returns the rows of an answer as lines of text, with the texts aligned in a column."""
    width = max(len(name) for name, _ in answer_rows(answer)) + 2
    return [f"{name:{width}}{text}" for name, text in answer_rows(answer)]


def page(
    answer: Finding,
    audit: Audit | ContactAudit,
    command: str,
    replay: Replay | None = None,
) -> str:
    """Returns the page of an audit as HTML. `command` repeats the audit; `replay` shows its
    motion."""
    table = answer.tables[0]
    text_rows = tuple((name, Cell(text.text, "text")) for name, text in table.rows)
    return page_of_finding(
        replace(answer, tables=(replace(table, rows=text_rows), *answer.tables[1:])),
        command,
        audit.seconds,
        versions=", ".join(f"{name} {version}" for name, version in package_versions().items()),
        seconds=notation.seconds,
        replay=replay,
        code=audit.snippet if isinstance(audit, ContactAudit) else "",
        card=() if isinstance(audit, ContactAudit) else card_lines(audit),
    )


def page_of_finding(finding: Finding, command: str, lasted: float, **about: Any) -> str:
    """Returns the page of a finding on one or more audits as HTML. `command` repeats them, `lasted`
    is their duration [s], and `about` holds further values of the template, all optional."""
    nothing = {"versions": "", "replay": None, "code": "", "card": ()}
    values = {"finding": finding, "command": command, "lasted": f"{lasted:.3g}", **nothing}
    return fill_page("audit.html.jinja", **{**values, **about})


def card_lines(audit: Audit) -> list[str]:
    """Returns the answer as a card for the terminal: a line with the error, the recommended choice
    and how well it is known; then the lines to put into the model file."""
    return text_lines("audit_card", audit=audit, advice=audit_advice(audit))


def package_versions() -> dict[str, str]:
    """Returns the versions of the packages that compute the numbers of an audit, by name."""
    return {name: metadata.version(name) for name in ("mujoco", "numpy", "scipy")}
