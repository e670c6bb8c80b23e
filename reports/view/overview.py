"""The tables at the top of the page: every verdict, and the cheapest way to each error."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import DEFAULT_METHOD, Choice, Recommendation
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Finding, StatementVerdict, Table, row

# Relative, and as they are written.
ERRORS = ((0.1, "10 %"), (1e-2, "1 %"), (1e-3, "0.1 %"), (1e-4, "1e-4"), (1e-6, "1e-6"))

Advice = Sequence[Recommendation]  # for each of these errors; empty where nothing was timed

# The sources in the order of the table, each with its places in the order of its text.
PLACES: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "Sudakov 2015": (
        "introduction", "terms", "characteristics", "(1)", "(2)–(6)", "(6)", "(6), (7)",
        "(7), (9)", "(8)", "(2)–(6), (9)", "(9), (15), (16), Fig. 3", "(10)–(13)", "(15), (16)",
        "(16)", "Fig. 2", "Fig. 2 e", "Fig. 3", "Fig. 3 b", "Fig. 3 c", "Fig. 3 e", "conclusion",
    ),
    "Chernousko 2020": (
        "assumptions", "(1)", "modes", "(2)–(4), (23)", "slow motions", "residual motions",
        "(5)–(7)", "(7)", "(3), (9)", "(8)–(12)", "(15)", "(17), (20), Fig. 2", "(18)",
        "(19), (20)", "(21)", "(22), Fig. 2", "(11)–(22)", "after (22)", "(24), (25)", "(28)",
        "(30)", "(31), Fig. 3", "(31), (32)", "(32)", "after (32)", "controllability",
        "controllability, 3", "conclusion",
    ),
    "Pêndulo Simples": (
        "equation of motion", "T", "linear equation", "F(t)", "parameters", "X₁, X₂", "integrator",
        *(f"case {number}" for number in range(1, 8)),
    ),
})  # fmt: skip
SOURCES = tuple(PLACES)
SOURCE_HEADS = ("source", "place", "statement", "the source's value", "ours", "verdict", "finding")
STATEMENT_WORDS: Mapping[StatementVerdict, str] = MappingProxyType(
    {"holds": "hold", "corrected": "corrected", "refuted": "refuted", "extended": "extended"}
)


def anchor(scene: str) -> str:
    """The id of a scene's place on the page."""
    return scene.replace("/", "-")


def recommendations(study: Study, by_scene: Mapping[str, Advice]) -> Table | None:
    """The cheapest method for each wanted error, a row a scene; None where nothing was timed."""
    if not study.costs:
        return None
    rows = []
    for scene in study.scenes:
        answers = by_scene[scene.name]
        unit = f"{answers[0].observable} [{answers[0].unit}]"
        name = Cell(scene.name, "scene", scene.summary, anchor(scene.name))
        default = next(iter(answers[0].defaults), None)
        usual = Cell("–", "number")
        if default is not None and default.method == DEFAULT_METHOD:
            usual = Cell(notation.number(default.error), "number", _said(default))
        rows.append(row(name, unit, *(_cell(answer) for answer in answers), usual))
    heads = ("scene", "quantity", *(f"within {name}" for _, name in ERRORS),
             "MuJoCo, default settings")  # fmt: skip
    note = (
        "Errors are relative: the worst of a scene's quantities of interest over their scales. "
        "From measured curves, on their upper envelope, interpolated and never extrapolated. "
        "Methods that do not converge, or are off what theory says, are left out, and so are "
        "surrogates, whose model is not the full body. "
        "The real-time factor is simulated time over computing time. Hover for the runner-up and "
        "for other engines. MuJoCo's default settings are Euler steps of 2 ms: the error that they "
        "have at that step."
    )
    return Table("The cheapest method and step for a wanted error, scene by scene", heads,
                 tuple(rows), note, folded=True)  # fmt: skip


def scene_recommendations(advice: Advice) -> Table | None:
    """The same for one scene, with runner-up, and what MuJoCo's default step gives."""
    if not advice:
        return None
    rows = []
    for (_, name), answer in zip(ERRORS, advice, strict=True):
        wanted = Cell(name, "number", f"{notation.number(answer.absolute)} {answer.unit}")
        if answer.choice is None:
            best = answer.best
            text = "nothing measured reaches it" if best else "nothing was measured"
            text += (
                f"; the best is {best.method} at {notation.step(best.step, best.control)}: "
                f"{notation.number(best.error)}"
                if best
                else ""
            )
            rows.append(row(wanted, Cell(text, "none", span=6)))
            continue
        second = answer.runner_up
        rows.append(
            row(
                wanted,
                Cell(answer.choice.method, "method"),
                Cell(notation.step(answer.choice.step, answer.choice.control), "number"),
                Cell(notation.times_real(answer.choice.ns_per_second), "number"),
                Cell(_said(second) if second else "none"),
                Cell("; ".join(_said(c) for c in answer.by_engine[1:] if c != second) or "–"),
                _surrogate(answer.surrogate),
            )
        )
    first = advice[0]
    note = "".join(
        f"The error of MuJoCo with default settings ({_said(c)} real time) is "
        f"{notation.relative(c.error)}, of {first.observable} at most "
        f"{notation.number(c.absolute)} {first.unit}."
        for c in first.defaults
        if c.method == DEFAULT_METHOD
    )
    heads = ("error wanted", "cheapest method", "step", "real-time factor", "runner-up",
             "in other engines", "surrogate, if cheaper")  # fmt: skip
    return Table("The cheapest method and step for a wanted error", heads, tuple(rows), note)


def _cell(answer: Recommendation) -> Cell:
    if answer.choice is None:
        best = answer.best
        hint = f"best: {notation.number(best.error)} with {best.method}" if best else "not measured"
        return Cell("not reached", "none", hint)
    choice = answer.choice
    text = f"{choice.method}\n{notation.step(choice.step, choice.control)}, "
    text += notation.times_real(choice.ns_per_second)
    others = [f"runner-up: {_said(answer.runner_up)}"] if answer.runner_up else []
    others += [_said(other) for other in answer.by_engine[1:] if other != answer.runner_up]
    return Cell(text, "choice", "; ".join(others))


def _surrogate(choice: Choice | None) -> Cell:
    return Cell(_said(choice), "", choice.surrogate) if choice else Cell("–", "none")


def _said(choice: Choice) -> str:
    return (
        f"{choice.method} at {notation.step(choice.step, choice.control)}, "
        f"{notation.times_real(choice.ns_per_second)}"
    )


def sources(findings: Sequence[Finding]) -> Table | None:
    """Every statement of the sources that these findings judge, in the order of their texts, each
    with a link to the finding that shows it; None where they judge none."""
    titles = {finding.name: finding.title for finding in findings}
    every = [(stated, finding) for finding in findings for stated in finding.statements]
    if not every:
        return None
    order = [(source, place) for source, places in PLACES.items() for place in places]
    rank = {both: number for number, both in enumerate(order)}
    rows = []
    # a place that is not listed comes last
    for stated, finding in sorted(
        every, key=lambda pair: rank.get((pair[0].source, pair[0].place), len(rank))
    ):
        name = stated.finding if stated.finding in titles else finding.name
        texts = (Cell(text, "text") for text in (stated.text, stated.said, stated.ours))
        verdict = Cell(stated.verdict, "text", stated.why)
        rows.append(
            row(stated.source, stated.place, *texts, verdict, Cell(titles[name], "text", "", name))
        )
    counted = Counter(stated.verdict for stated, _ in every)
    counts = ", ".join(f"{counted[word]} {means}" for word, means in STATEMENT_WORDS.items())
    note = (
        "Ours: computed from the exact solutions and from the runs of this study. A printed number "
        "holds where ours rounds to it. Hover over a verdict for its reason."
    )
    return Table(f"What the sources say, and what was found: {counts}", SOURCE_HEADS, tuple(rows),
                 note, folded=True)  # fmt: skip
