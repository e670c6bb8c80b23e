"""The numbers that are shipped with the package are those that are computed now."""

import json
import math
from dataclasses import replace
from datetime import date

import pytest

from plumbob.engines.study.codec import from_json
from plumbob.engines.study.results import Analysed
from plumbob.reports.analyses.analysis import with_exact_numbers
from plumbob.reports.records.exact_numbers import (
    EXACT_NUMBERS,
    ExactNumbers,
    exact_numbers_file,
    exact_numbers_of,
)
from plumbob.reports.view.finding_text import findings_of
from plumbob.tests.support.declared import nothing
from plumbob.tests.validation.exact_numbers import (
    PACKAGES,
    computed_now,
    exact_analyses,
    main,
    text_of,
)
from plumbob.tests.validation.loop_findings import COMPUTED

ANALYSES = exact_analyses()
# These take one to fourteen seconds of processor time each: `make test-long` computes them.
SLOW = {
    "capsule_line/experiment",
    "capsule_plan/legs",
    "capsule_plan/poses",
    "cone_pendulum/source_text",
    "simple_pendulum/notebook_bob",
    "simple_pendulum/notebook_claims",
    "simple_pendulum/notebook_rk4",
}
# Computed with the vector instructions of another processor (without AVX and FMA in numpy, and with
# the kernels of another processor in OpenBLAS), numbers that are rounding alone differ by 9e-14 at
# most, and the others by a part of 9e-10 at most, but for those of AMPLIFIED. Allowed is ten times
# as much.
ABSOLUTE, RELATIVE = 1e-12, 1e-8
AMPLIFIED = {
    "capsule_turn/second_order.factor": 7e-3,  # from a difference of differences
    "capsule_turn/second_order.corrected.slopes": 4e-6,  # of errors down to 1e-12
    "capsule_turn/left_over.rows": 4e-4,  # from 1 - 1e-5, and speeds down to 1e-8 m/s
    "capsule_turn/source.friction": 2e-4,  # the largest of samples, whose times are found
}


def apart(shipped, computed, place, relative=RELATIVE):
    """Yields a line for each number, and for each text, that differs by more than is allowed."""
    relative = AMPLIFIED.get(place, relative)
    if isinstance(shipped, dict):
        if shipped.keys() != computed.keys():
            yield f"{place}: {sorted(shipped)}, now {sorted(computed)}"
            return
        for name in shipped:
            yield from apart(shipped[name], computed[name], f"{place}.{name}", relative)
    elif isinstance(shipped, tuple):
        if len(shipped) != len(computed):
            yield f"{place}: {len(shipped)} entries, now {len(computed)}"
            return
        for number, (one, other) in enumerate(zip(shipped, computed, strict=True)):
            yield from apart(one, other, f"{place}[{number}]", relative)
    elif isinstance(shipped, float) and isinstance(computed, float):
        both_nan = math.isnan(shipped) and math.isnan(computed)
        if not both_nan and not math.isclose(
            shipped, computed, rel_tol=relative, abs_tol=ABSOLUTE
        ):
            yield f"{place}: {shipped}, now {computed}"
    elif shipped != computed:
        yield f"{place}: {shipped}, now {computed}"


@pytest.mark.parametrize("template", ANALYSES)
def test_shipped_numbers_are_those_that_are_computed_now(template, pytestconfig):
    if template in SLOW and pytestconfig.getoption("--profile") == "quick":
        pytest.skip("computed by make test-long")
    # The numbers are written and read again, as the numbers of the page were.
    computed = from_json(text_of(computed_now(ANALYSES[template])), ExactNumbers)
    shipped = exact_numbers_of(template)
    assert list(apart(shipped.numbers, computed.numbers, template)) == []


@pytest.mark.parametrize(
    ("shipped", "computed"),
    [
        ({"x": 1.0}, {"x": 1.0 + 2e-8}),
        ({"x": (0.0, 1e-11)}, {"x": (0.0, 0.0)}),
        ({"x": 1.0}, {"x": 1.0, "y": 2.0}),
        ({"x": (1.0,)}, {"x": (1.0, 2.0)}),
        ({"x": math.nan}, {"x": 1.0}),
        ({"x": "slide"}, {"x": "stick"}),
        ({"friction": 1.0}, {"friction": 1.0 + 3e-4}),
    ],
)
def test_another_number_is_seen(shipped, computed):
    assert len(list(apart(shipped, computed, "capsule_turn/source"))) == 1
    assert list(apart(shipped, shipped, "capsule_turn/source")) == []


def test_each_file_belongs_to_an_analysis_and_names_its_day_and_versions():
    files = {file for file in EXACT_NUMBERS.rglob("*") if file.is_file()}
    assert files == {exact_numbers_file(template) for template in (*ANALYSES, *COMPUTED)}
    for template in ANALYSES:
        shipped = exact_numbers_of(template)
        assert date.fromisoformat(shipped.date)
        assert set(shipped.versions) == set(PACKAGES)
        assert shipped.numbers


def test_a_file_is_written_as_it_is_shipped(tmp_path, monkeypatch, capsys):
    template = "capsule_train/mean_speed"
    shipped = exact_numbers_file(template).read_text("utf-8")
    monkeypatch.setattr("plumbob.reports.records.exact_numbers.EXACT_NUMBERS", tmp_path)
    assert main([template]) == 0
    assert capsys.readouterr().out == f"{tmp_path / template}.json\n"
    written = exact_numbers_file(template).read_text("utf-8")
    assert json.loads(written).keys() == json.loads(shipped).keys()
    assert written.partition("numbers")[2] == shipped.partition("numbers")[2]
    with pytest.raises(SystemExit):
        main(["cone_pendulum/equilibria"])


def test_an_older_study_is_drawn_with_the_shipped_numbers():
    """It holds such numbers too, perhaps fewer, and computed by another version."""
    template = "capsule_train/mean_speed"
    analysis = Analysed(template, "finding", "capsule-train", "", {})
    older = replace(analysis, numbers={"checked": 99.0, "gone": 1.0})
    assert findings_of(older) == findings_of(analysis)
    (finding,) = findings_of(analysis)
    assert finding.exact == exact_numbers_of(template)


def test_claims_see_shipped_and_measured_numbers_together():
    analysis = ANALYSES["simple_pendulum/notebook_claims"]
    numbers = with_exact_numbers(analysis, analysis.numbers(nothing()))
    assert numbers.mujoco is None
    assert numbers.damping_ratio == pytest.approx(0.08 / (2 * math.sqrt(9.8)), rel=1e-12)
