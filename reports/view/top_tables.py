"""The tables at the top of the page: every verdict, and the cheapest way to each error."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import DEFAULT_METHOD, Recommendation
from plumbob.reports.view.content import Finding, Table
from plumbob.reports.view.sources import listed
from plumbob.reports.view.tables import table, table_or_none

# Relative, and as they are written.
ERRORS = ((0.1, "10 %"), (1e-2, "1 %"), (1e-3, "0.1 %"), (1e-4, "1e-4"), (1e-6, "1e-6"))

Advice = Sequence[Recommendation]  # for each of these errors; empty where nothing was timed


def anchor(scene: str) -> str:
    """The id of a scene's place on the page."""
    return scene.replace("/", "-")


def recommendations(study: Study, by_scene: Mapping[str, Advice]) -> Table | None:
    """The cheapest method for each wanted error, a row a scene; None where nothing was timed."""
    if not study.costs:
        return None
    rows = [(scene, by_scene[scene.name]) for scene in study.scenes]
    return table("recommendations", rows=rows, errors=ERRORS, default=DEFAULT_METHOD)


def scene_recommendations(advice: Advice) -> Table | None:
    """The same for one scene, with runner-up, and what MuJoCo's default step gives."""
    if not advice:
        return None
    answers = [(name, answer) for (_, name), answer in zip(ERRORS, advice, strict=True)]
    return table("scene_recommendations", answers=answers, default=DEFAULT_METHOD)


def sources(findings: Sequence[Finding]) -> Table | None:
    """Every statement of the sources that these findings judge, in the order of their texts, each
    with a link to the finding that shows it; None where they judge none."""
    titles = {finding.name: finding.title for finding in findings}
    order = dict.fromkeys((entry.source, entry.place) for entry in listed())
    rank = {both: number for number, both in enumerate(order)}  # one not listed comes last
    rows = [
        (of, of.finding if of.finding in titles else finding.name)
        for finding in findings
        for of in finding.statements
    ]
    rows.sort(key=lambda row: rank.get((row[0].source, row[0].place), len(rank)))
    counted = Counter(of.verdict for of, _ in rows)
    return table_or_none("sources", rows=rows, titles=titles, counted=counted)


def every_statement(findings: Sequence[Finding]) -> Table:
    """Every statement of the sources' texts, and by which finding and second method it is computed,
    or why it cannot be."""
    titles = {finding.name: finding.title for finding in findings}
    return table("every_statement", rows=listed(), titles=titles)
