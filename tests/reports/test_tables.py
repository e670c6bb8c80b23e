"""The tables of a scene show what they say: the finest run, and the predicted beside the observed
order."""

import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import measure
from plumbob.engines.study.order import Order
from plumbob.models.registry import case_of, system_of, systems
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses import section
from plumbob.reports.analyses.cone_pendulum import source_claims
from plumbob.reports.analyses.page_numbers import verdict_on
from plumbob.reports.judge.tolerance import round_off, tolerance, tolerance_excess
from plumbob.reports.judge.verdict import JudgedMethod, judge
from plumbob.reports.records import notation
from plumbob.reports.view import sources, tables, top_tables
from plumbob.reports.view.content import StatementVerdict
from plumbob.reports.view.method_results import MethodResult
from plumbob.reports.view.sources import NOTEBOOK
from plumbob.reports.view.units import parameter_units
from plumbob.tests.site import whole_profile
from plumbob.tests.support.declared import finding, nothing
from plumbob.tests.support.studies import SCENE, quick

TESTS = Path(__file__).parents[1]


def measured():
    """What the small study measured on its scene."""
    return [c for c in quick().convergence if c.scene == SCENE]


def by_name():
    """The methods of the small study."""
    return {m.name: m for m in quick().methods}


def texts(table):
    """The cells of a table by their head, a list each."""
    rows = [[cell.text for cell in row] for row in table.rows]
    columns = list(zip(*rows, strict=True))
    return {head: list(column) for head, column in zip(table.heads, columns, strict=True)}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.5, "1.5 s"),
        (2.5e-3, "2.5 ms"),
        (1e-3, "1 ms"),
        (320e-6, "320 µs"),
        (5e-6, "5 µs"),
        (9.9e-7, "990 ns"),
    ],
)
def test_a_time_has_the_unit_that_suits_it(value, text):
    assert notation.seconds(value) == text


@pytest.mark.parametrize(
    ("written", "text"),
    [
        (notation.seconds(9.996e-4), "1 ms"),
        (notation.seconds(9.99e-4), "999 µs"),
        (notation.metres(9.96e-4), "1 mm"),
        (notation.metres(9.94e-4), "990 µm"),
        (notation.factor(156.0), "160"),
        (notation.factor(81234.0), "81,000"),
        (notation.factor(1.62), "1.6"),
        (notation.shortest(0.1 + 0.2), "0.3"),
        (notation.shortest(9.81), "9.81"),
        (notation.shortest(((0.2, 0.0), (-0.1, 0.3 - 0.15))), "((0.2, 0), (-0.1, 0.15))"),
        (notation.shortest("newton"), "newton"),
        (notation.milliseconds(7.768e6), "7.77"),
    ],
)
def test_numbers_have_the_digits_and_the_unit_that_suit_them(written, text):
    """No 1000 µm, no 1.6e+02, no 0.30000000000000004."""
    assert written == text


def test_parameters_have_their_unit():
    facts = {"period": 0.32, "outcome": "sticks"}
    parameters = {"friction": 0.1 + 0.2, "w1": 38.259000000000007}
    shown = tables.table(
        "parameters", parameters=parameters, facts=facts, source="", units=parameter_units()
    )
    rows = [tuple(cell.text for cell in row) for row in shown.rows]
    assert rows == [
        ("friction", "0.3", "1"),
        ("w1", "38.259", "m/s²"),
        ("period", "0.32", "s"),
        ("outcome", "sticks", ""),
    ]


def test_a_real_time_factor_is_simulated_over_computing_time():
    assert notation.real_time_factor(1e9) == "1"
    assert notation.times_real(2e6) == "500×"  # 2 ms of computing for a simulated second
    assert notation.times_real(4e9) == "0.25×"
    assert notation.times_real(0.0) == "–"


def test_predicted_and_observed_orders_stand_in_their_columns():
    (rk4,) = [c for c in measured() if c.method == "ode/rk4"]
    steps = rk4.measurements[0].step, rk4.measurements[1].step
    order = Order(3.5, 3.4, 3.6, steps)
    predicted = Order(2.5, 2.4, 2.6, steps)
    series = replace(rk4, order=order, predicted_order=predicted)
    method = by_name()[rk4.method]
    of = MethodResult(find_scene(rk4.scene), method, series, None, ())
    shown = texts(tables.table("orders", rows=[of]))
    assert shown["observed [95 % interval]"][0].startswith("3.5")
    assert shown["predicted here"][0].startswith("2.5")


def test_a_rounding_of_zero_is_no_failure():
    """The heading on a line is exactly zero, and theory allows it nothing."""
    scene = find_scene("capsule-line/ca1")
    how = find_method("mujoco/euler")
    system = system_of(scene)
    units = {o.name: o.unit for o in system_of(scene).observables}
    found, _ = measure(case_of(scene), how, 1e-3)
    heading = found.errors["heading"]
    assert heading.scale == 0.0
    allowed = tolerance(found, how, "heading", "rad")
    assert allowed
    level = round_off(found, "heading", units)
    assert 0.0 < heading.largest < level < 1e-13
    assert tolerance_excess(found, "heading", allowed, units) is None
    shown = judge(found, system, how)
    assert shown.verdict == "off-prediction"  # of the displacement
    c = ConvergenceStudy(scene.name, how.name, (found,))
    study = replace(nothing(), scenes=(scene,), methods=(how,), convergence=(c,))
    both = verdict_on(study, c, {(scene.name, how.name): JudgedMethod(shown, (shown,))})
    of = MethodResult(scene, how, c, both, ())
    cells = texts(tables.table("budgets", rows=[of], units=units))
    rows = zip(cells["observable"], cells["reason"], strict=True)
    said = {head.partition(",")[0]: why for head, why in rows if ", error" in head}
    assert said["heading"] == said["sideways"] == "the sum: within"
    assert said["displacement"] == "the sum: EXCEEDED"
    more = replace(heading, largest=1.01 * level)  # and no more than rounding
    wrong = replace(found, errors={**found.errors, "heading": more})
    assert tolerance_excess(wrong, "heading", allowed, units) is not None


# Every number that a source prints as a result of its own.
PRINTED = ("16.24", "0.893", "0.031", "35.809", "39.624", "514.197", "575.246", "500", "0.08")


@pytest.fixture(scope="module")
def findings():
    """All findings of the quick profile, from made-up runs."""
    return list(whole_profile.findings())


@pytest.mark.long
def test_every_statement_of_the_sources_has_value_verdict_and_finding(
    findings,
):
    table = top_tables.sources(findings)
    assert table.folded
    known = {finding.name: finding.title for finding in findings}
    for source, place, text, said, ours, verdict, link in table.rows:
        assert all(cell.text for cell in (source, place, text, said, ours))
        assert verdict.text in get_args(StatementVerdict)
        assert known[link.link] == link.text
        for number in re.findall(r"\d+\.\d+", text.text):
            assert number in said.text
    assert list(dict.fromkeys(line[0].text for line in table.rows)) == [*sources.CITED_SOURCES]
    shown = [(line[0].text, line[1].text) for line in table.rows]
    order = list(dict.fromkeys((of.source, of.place) for of in sources.listed_statements()))
    assert set(shown) <= set(
        order
    )  # list a new statement in statements.toml, where its text has it
    assert shown == sorted(shown, key=order.index)
    words = " ".join(line[3].text for line in table.rows).split()
    assert {number for number in PRINTED if not any(number in word for word in words)} == set()
    texts = [line[2].text for line in table.rows if line[0].text != NOTEBOOK]
    assert len(texts) == len(set(texts))
    links = {line[6].link for line in table.rows}
    assert {"uniformity", "special-functions", "no-symmetry", "generating-solution"} <= links
    assert top_tables.sources([]) is None


@pytest.mark.long
def test_every_statement_of_the_texts_is_computed_twice_or_cannot_be(
    findings,
):
    """By a finding of the page and by a test of its own; and every judged statement is listed."""
    every = sources.listed_statements()
    names = {finding.name for finding in findings}
    galleries = [of for name in systems() if (shown := section(name)) for of in shown.galleries]
    names |= {of.template.rpartition("/")[2].replace("_", "-") for of in galleries}
    computed = [of for of in every if of.finding]
    assert (len(every), len(computed)) == (176, 165)
    assert list(dict.fromkeys(of.source for of in every)) == [*sources.CITED_SOURCES]
    assert len({(of.source, of.place, of.text) for of in every}) == len(every)
    assert {of.finding for of in computed} <= names
    for of in every:
        assert of.beside
        assert bool(of.test) == bool(of.finding)
        if of.test:
            path, _, name = of.test.partition("::")
            assert f"def {name}(" in (TESTS / path).read_text("utf-8"), of.test
    table = top_tables.sources(findings)
    judged = {(line[0].text, line[1].text, line[6].link) for line in table.rows}
    shown_by = {"uniformity": "claims", "special-functions": "claims"}
    listed = {(of.source, of.place, of.finding) for of in computed}
    for source, place, name in judged:
        assert listed & {(source, place, name), (source, place, shown_by.get(name, ""))}
    drawn = top_tables.every_statement(findings)
    assert len(drawn.rows) == len(every)
    assert "176, of which 165 are computed and 11 cannot be" in drawn.caption


def test_printed_numbers_of_the_source_hold():
    """The barrier on the turning platform as the largest of 300 samples, which is the source's."""
    statements = finding(source_claims.CONE_CLAIMS, nothing()).statements[:7]
    found = {one.said: one.verdict for one in statements}
    assert [said for said, verdict in found.items() if verdict != "holds"] == []
    assert len(found) == 7
    top = 514.19980544461671  # J, with 40 digits
    assert source_claims.largest_sampled_potential() == pytest.approx(514.1970344, abs=1e-7)
    assert top - source_claims.largest_sampled_potential() > 2e-3  # which rounds to 514.200
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(source_claims, "WORKSHEET_ANGLES", 260)
        assert round(source_claims.largest_sampled_potential(), 3) != 514.197
