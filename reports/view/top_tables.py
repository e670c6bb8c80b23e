"""Tables of recommended methods, and tables of the sources' statements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import DEFAULT_METHOD, Recommendation
from plumbob.reports.view.content import Finding, Table
from plumbob.reports.view.sources import listed_statements
from plumbob.reports.view.tables import table, table_or_none

# relative errors, each with its text on the page
ERRORS = ((0.1, "10 %"), (1e-2, "1 %"), (1e-3, "0.1 %"), (1e-4, "1e-4"), (1e-6, "1e-6"))

Advice = Sequence[Recommendation]  # one for each of `ERRORS`; empty if nothing was timed


def anchor(scene: str) -> str:
    """Returns the id of a scene in the pages."""
    return scene.replace("/", "-")


def recommendations(study: Study, by_scene: Mapping[str, Advice]) -> Table | None:
    """Returns the table of the cheapest method for each error of `ERRORS`, with a row for each
    scene; None if nothing was timed."""
    if not study.costs:
        return None
    rows = [(scene, by_scene[scene.name]) for scene in study.scenes]
    return table("recommendations", rows=rows, errors=ERRORS, default=DEFAULT_METHOD)


def scene_recommendations(advice: Advice) -> Table | None:
    """Returns the table of the cheapest method of one scene for each error of `ERRORS`, with the
    runner-up and the error of MuJoCo's default step; None if nothing was timed."""
    if not advice:
        return None
    answers = [(name, answer) for (_, name), answer in zip(ERRORS, advice, strict=True)]
    return table("scene_recommendations", answers=answers, default=DEFAULT_METHOD)


def sources(findings: Sequence[Finding]) -> Table | None:
    """Returns the table of the sources' statements that `findings` judge, in the order of the
    sources' texts, each with a link to the finding that shows it; None if no statement is
    judged."""
    titles = {finding.name: finding.title for finding in findings}
    order = dict.fromkeys((entry.source, entry.place) for entry in listed_statements())
    rank = {
        place: number for number, place in enumerate(order)
    }  # unlisted statements come last
    rows = []  # statement, name of the finding that shows its result
    for finding in findings:
        for statement in finding.statements:
            shown_by = statement.finding if statement.finding in titles else finding.name
            rows.append((statement, shown_by))
    rows.sort(key=lambda row: rank.get((row[0].source, row[0].place), len(rank)))
    counted = Counter(statement.verdict for statement, _ in rows)
    return table_or_none("sources", rows=rows, titles=titles, counted=counted)


def every_statement(findings: Sequence[Finding]) -> Table:
    """Returns the table of all statements of the sources. A row names the finding and the
    independent method that compute the statement, or the reason that it cannot be computed."""
    titles = {finding.name: finding.title for finding in findings}
    return table("every_statement", rows=listed_statements(), titles=titles)
