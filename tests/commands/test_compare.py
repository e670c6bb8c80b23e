"""`plumbob compare`: versions, what vanished, what moved beyond rounding, and a limit on growth."""

import json
from dataclasses import replace

import pytest

from plumbob.engines.registry import methods
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import matching_scenes
from plumbob.reports.cli import main
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.tests.support.page_document import Document, broken_links
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import remeasured

# x stays at zero on the scene of the second system, but for rounding.
SCENES, METHODS = (
    "cone-pendulum/deep-well,capsule-coast/rotation",
    "mujoco/euler,mujoco/rk4+coulomb",
)
EULER, STEP = "cone-pendulum/deep-well mujoco/euler", 1e-3


@pytest.fixture(scope="module")
def study():
    chosen = [replace(s, steps=(2e-3, STEP)) for s in matching_scenes(SCENES)]
    return run_study(chosen, methods(METHODS), timed=False)


def changed(study, change):
    """The study with another run of mujoco/euler at 1 ms on the cone."""

    def each(m):
        return change(m) if f"{m.scene} {m.method}" == EULER and m.step == STEP else m

    return remeasured(study, each)


def errors_times(factor):
    """Every error of a run by a factor."""
    return lambda m: replace(
        m, errors={n: replace(e, largest=factor * e.largest) for n, e in m.errors.items()}
    )


@pytest.fixture
def compare(study, tmp_path, capsys):
    def run(new, *more, old=study):
        for name, one in (("a", old), ("b", new)):
            (tmp_path / name).unlink(missing_ok=True)
            save(one, tmp_path / name)
        code = main(["compare", str(tmp_path / "a"), str(tmp_path / "b"), *more])
        return code, capsys.readouterr().out

    return run


def test_versions_that_differ_are_named(study, compare):
    versions = {**study.provenance.versions, "mujoco": "99.0"}
    newer = replace(study, provenance=replace(study.provenance, versions=versions))
    was = study.provenance.versions["mujoco"]
    assert f"\nversion of mujoco: {was} -> 99.0\n" in compare(newer)[1]
    (row,) = json.loads(compare(newer, "--json")[1])
    assert (row["what"], row["old"], row["new"]) == ("version of mujoco", was, "99.0")


@pytest.mark.parametrize(
    ("factor", "above", "code"),
    [(1.06, "5%", 1), (1.04, "5%", 0), (1.06, "0.05", 1), (0.5, "5%", 0), (1.04, None, 0)],
)
def test_growth_beyond_the_limit_is_exit_code_1(
    factor, above, code, study, compare, monkeypatch
):
    judged = judge_study(study)
    monkeypatch.setattr("plumbob.reports.judge.study_differences.judge_study", lambda _: judged)
    more = [] if above is None else ["--fail-above", above]
    found, out = compare(changed(study, errors_times(factor)), *more)
    assert found == code
    assert f"{EULER}: theta error at 0.001 " in out
    assert f"({100 * (factor - 1):+.2g} %)" in out
    assert ("grew by more than" in out) == (code == 1)


@pytest.mark.parametrize(("factor", "listed"), [(1 + 1e-7, True), (1 + 1e-12, False)])
def test_a_small_change_is_listed_beyond_rounding(factor, listed, study, compare):
    assert (
        "theta error at 0.001" in compare(changed(study, errors_times(factor)))[1]
    ) == listed


def test_what_vanished_and_what_is_new_is_said(study, compare):
    first, *rest = study.convergence
    _, out = compare(replace(study, convergence=tuple(rest)))
    assert f"{first.scene} {first.method}: measured yes -> no" in out
    shorter = replace(first, measurements=first.measurements[:-1])
    _, out = compare(replace(study, convergence=(shorter, *rest)))
    last = first.measurements[-1].step
    assert f"{first.scene} {first.method}: measured at {last:g} yes -> no" in out


def test_a_page_of_it(study, compare, tmp_path):
    """It says what moved, in the frame of all pages, with both studies' versions."""
    file = tmp_path / "compared.html"
    older = replace(study.provenance, versions={**study.provenance.versions, "mujoco": "3.1.4"})
    code, said = compare(
        changed(study, errors_times(1.5)),
        "--page",
        str(file),
        "--fail-above",
        "20%",
        old=replace(study, provenance=older),
    )
    assert code == 1
    assert f"page: {file}" in said
    text = file.read_text("utf-8")
    document = Document(text)
    assert broken_links({file: document}) == []
    for words in (
        "The errors of 1 pair changed by more than rounding explains",
        "errors grew by more than 20 %",
        "3.1.4",
        f"plumbob compare {tmp_path}",
    ):
        assert words in text, words
    cells = " ".join(document.cells)
    assert "theta error at 0.001" in cells
    assert "+50 %" in cells
