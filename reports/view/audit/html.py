"""The page of an audit: its content, its HTML, and the sample page that is shipped with the
package."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from plumbob.engines.study.codec import from_json
from plumbob.reports.records.page_records import Replay
from plumbob.reports.view.content import Finding, Table
from plumbob.reports.view.page import fill_page

# content of the page of one of plumbob's models, audited when the package was tested
SAMPLE_AUDIT = Path(__file__).with_name("sample.json")


@dataclass(frozen=True)
class Tile:
    """The answer to one question about a model, with its grade."""

    question: str
    grade: str  # good, fair, bad or unknown
    text: str


@dataclass(frozen=True)
class AuditReport:
    """The first part of an audit's page: what is wrong, and what to do."""

    headline: str
    tiles: tuple[Tile, ...]
    warnings: tuple[str, ...]
    advised: tuple[str, ...]  # the changes that the audit advises, a line each
    fixes: Table | None  # None if no change makes the model better


@dataclass(frozen=True)
class AuditPage:
    """The content of the page of one or more audits."""

    finding: Finding
    command: str  # repeats the audits
    lasted: float  # [s]
    versions: Mapping[str, str] = field(default_factory=dict)  # by package
    replay: Replay | None = None
    code: str = ""  # MJCF to paste
    report: AuditReport | None = None  # None for several audits, and for an audit of contacts
    card: tuple[str, ...] = ()  # the answer in one line, then the lines to put into the file


def audit_html(content: AuditPage) -> str:
    """Returns the page with this content as one HTML file."""
    return fill_page("audit.html.jinja", **vars(content))


def sample_audit() -> AuditPage:
    """Returns the content of the sample page."""
    return from_json(SAMPLE_AUDIT.read_text("utf-8"), AuditPage)
