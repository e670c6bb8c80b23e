"""What `validate` and `run` tell a person and a CI system: exit codes, JUnit XML, the terminal."""

import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from plumbob.engines import registry
from plumbob.engines.method import KnownLimit
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import matching_scenes
from plumbob.models.registry import scene as find_scene
from plumbob.reports.cli import main
from plumbob.reports.judge import expectations
from plumbob.reports.judge.expectations import (
    expected,
    run_surprise,
    standing,
    surprise,
    verdict_is_expected,
)
from plumbob.reports.judge.verdict import Judgement
from plumbob.reports.records import notation
from plumbob.tests.commands.outcomes import (
    break_engine,
    declare,
    validated,
    without_findings,
    without_pages,
)

CONE, LINE, TURN = "cone-pendulum/deep-well", "capsule-line/ca1", "capsule-turn/0.3"
QUICK = "cone-pendulum/rotating-base"
METHODS = "mujoco/euler,ode/rk4,exact/closed-form"


@pytest.fixture
def whole(tmp_path, capsys):
    """A `validate` of scenes and methods."""
    return partial(validated, tmp_path, capsys)


@pytest.fixture
def validate(whole, monkeypatch):
    """The same without the page, and without the runs that only the page shows."""
    without_pages(monkeypatch)
    return whole


def test_all_as_expected(validate):
    found = validate(f"{CONE},{LINE},{TURN}", METHODS)
    assert found.code == 0
    counts = {
        name: found.junit.get(name) for name in ("tests", "failures", "errors", "skipped")
    }
    cases = found.junit.findall("testcase")
    skipped = found.junit.findall("testcase/skipped")
    assert counts == {
        "tests": str(len(cases)),
        "failures": "0",
        "errors": "0",
        "skipped": str(len(skipped)),
    }
    limit = found.case(LINE, "mujoco/euler").find("skipped")
    assert limit.attrib["message"].startswith("known limit, not-converging: contact chatter")
    closed = found.case(TURN, "exact/closed-form").find("skipped")
    assert closed.attrib["message"].startswith("unsupported: ")
    assert found.case(CONE, "ode/rk4").find("skipped") is None
    assert "UNEXPECTED" not in found.out
    counts = "the page counts the pairs that ran; a declared pair counts as a known limit"
    (said,) = [line for line in found.out.splitlines() if line.startswith(counts)]
    assert said.endswith(": 4 as predicted, 0 converges, 2 known limits")


@pytest.mark.long
def test_an_engine_that_refuses_every_model_is_unexpected(whole, monkeypatch):
    break_engine(monkeypatch, "mujoco")
    without_findings(monkeypatch)
    found = whole(f"{CONE},{LINE}", "mujoco/euler,mujoco/euler+coulomb,ode/rk4")
    assert found.code == 1
    for scene, method in ((CONE, "mujoco/euler"), (LINE, "mujoco/euler+coulomb")):
        failure = found.case(scene, method).find("failure")
        message = "unsupported, expected predicted: the compiler refuses this model"
        assert failure.attrib["message"] == message
        assert f"UNEXPECTED {scene} {method}: unsupported, expected predicted" in found.out
    # It is no known limit either that the engine does not run at all.
    assert found.case(LINE, "mujoco/euler").find("failure") is not None
    assert found.junit.attrib["failures"] == "3"
    assert found.case(CONE, "ode/rk4").find("failure") is None
    page = Path(found.out.splitlines()[-1].removeprefix("page: ")).read_text("utf-8")
    assert "✗ 3 unexpected" in page


def test_a_limit_that_disappears_is_first_on_the_terminal(validate, monkeypatch):
    declare(monkeypatch, KnownLimit("cone-*", "ode/rk4", "off-prediction", "a limit of old"))
    found = validate(CONE, "mujoco/euler,ode/rk4")
    assert found.code == 1
    assert found.out.splitlines()[:3] == [
        f"UNEXPECTED {CONE} ode/rk4: predicted, expected off-prediction",
        "  every error is within its tolerance",
        "  declared: a limit of old",
    ]
    assert "predicted (UNEXPECTED)" in found.out
    assert found.junit.attrib["failures"] == "1"
    assert "0 known limits, 1 unexpected" in found.out


def test_an_engine_that_is_missing_leaves_the_study_incomplete(validate, monkeypatch):
    monkeypatch.setattr(
        "plumbob.engines.study.measurement.installed", lambda engine: engine.name != "mujoco"
    )
    found = validate(CONE, "mujoco/euler,ode/rk4")
    assert found.code == 3
    missing = found.case(CONE, "mujoco/euler").find("skipped")
    assert missing.attrib["message"] == "missing: mujoco is missing"
    # A surprise outweighs what is missing.
    declare(monkeypatch, KnownLimit("cone-*", "ode/rk4", "off-prediction", "a limit of old"))
    assert validate(CONE, "mujoco/euler,ode/rk4").code == 1


def test_the_table_and_the_last_lines(validate):
    found = validate(f"{CONE},{LINE}", METHODS)
    lines = found.out.splitlines()
    said = found.properties(CONE, "ode/rk4")
    (row,) = [line for line in lines if line.strip().startswith("ode/rk4 ")]
    cells = re.split(r" {2,}", row.strip())
    assert cells[:2] == ["ode/rk4", "predicted"]
    assert cells[2] == notation.number(float(said["relative_error"]), 2)
    assert cells[3] == notation.step(float(said["step"]), "step") == "0.001 s"
    assert said["quantity"] == "theta"
    assert float(cells[4]) == pytest.approx(float(said["order"]), abs=0.006)
    assert cells[5].endswith("×")
    assert any("relative error of theta " in line for line in lines)
    assert any("not-converging (known)" in line for line in lines)
    runs, limits, page = lines[-3:]
    assert page.startswith("page: ")
    assert re.fullmatch(r"\d+ runs, 5 verdicts: 4 predicted, 1 not-converging", runs)
    assert limits == "1 known limit, 0 unexpected"


@pytest.mark.parametrize(
    ("scene", "methods", "others"),
    [
        ("projectile/thrown", "mujoco/euler+coulomb", ", such as mujoco/euler, "),
        ("pinch/0.5", "heyoka/*", ""),
    ],
)
def test_a_study_without_runs_is_refused(capsys, tmp_path, scene, methods, others):
    words = ["validate", "--scenes", scene, "--methods", methods, "--jobs", "1"]
    assert main([*words, "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(
        f"methods = .*: must be methods that are meant for these scenes{others}", line
    )
    assert not list(tmp_path.iterdir())


def test_verbose_adds_reasons_intervals_and_costs(validate):
    plain, verbose = (validate(LINE, "mujoco/euler", v) for v in ((), ("-v",)))
    assert " ns" not in plain.out
    assert "times the round-off level" not in plain.out
    assert "cost of a step" in verbose.out
    assert re.search(r"\d ns +\S+ +\S+ s$", verbose.out, re.MULTILINE)
    converging = validate(CONE, "ode/rk4", ("-v",)).out.splitlines()
    (row,) = [line for line in converging if line.strip().startswith("ode/rk4 ")]
    cells = re.split(r" {2,}", row.strip())
    assert float(cells[-2]) < float(cells[2])  # the smallest error, and the reference step's
    assert float(cells[-1].removesuffix(" s")) < float(cells[3].removesuffix(" s"))
    assert re.search(r"stays at \S+, [\d.e+]{1,8} times the round-off level", verbose.out)


RUN = ("run", CONE, "ode/rk4", "--step", "1e-3")


def test_run_of_an_unexpected_verdict_is_exit_code_1(monkeypatch):
    assert main(RUN) == 0
    declare(monkeypatch, KnownLimit("cone-*", "ode/rk4", "off-prediction", "a limit of old"))
    assert main(RUN) == 1


def test_run_of_what_is_declared_unsupported_is_as_expected():
    assert main(("run", TURN, "exact/closed-form", "--step", "1e-10")) == 0


def test_run_of_a_missing_engine_is_exit_code_3(monkeypatch):
    monkeypatch.setattr("plumbob.engines.study.measurement.installed", lambda engine: False)
    assert main(RUN) == 3


@pytest.mark.parametrize(
    ("method", "verdict", "cut", "accepted"),
    [
        ("ode/rk4", "predicted", False, True),
        ("ode/rk4", "pre-asymptotic", False, False),
        ("ode/rk4", "pre-asymptotic", True, False),
        ("ode/dop853", "pre-asymptotic", False, False),
        ("ode/rk4", "converges", False, False),  # a theory covers it
        ("ode/rk4", "off-prediction", True, False),
        ("ode/rk4", "not-converging", True, False),
        ("ode/rk4", "diverged", True, False),
    ],
)
def test_what_is_accepted_of_a_scene_that_is_not_hard(method, verdict, cut, accepted):
    found = Judgement(verdict, {}, "a reason", cut)
    assert verdict_is_expected(find_scene(QUICK), registry.method(method), found) == accepted
    means = standing(find_scene(QUICK), registry.method(method), found)
    assert (means == "unexpected") == (not accepted)
    assert (means == "as expected") == accepted


@pytest.mark.parametrize(
    ("verdict", "cut", "accepted"),
    [
        ("not-converging", False, True),
        ("off-prediction", True, True),
        ("off-prediction", False, False),
        ("predicted", False, False),
        ("diverged", True, False),
    ],
)
def test_what_is_accepted_of_a_known_limit(verdict, cut, accepted):
    known = registry.limits_of("mujoco/euler").sizes[LINE, "mujoco/euler"]
    found = Judgement(verdict, {}, "a reason", cut, errors={known.fine: known.size})
    how = registry.method("mujoco/euler")
    assert verdict_is_expected(find_scene(LINE), how, found) == accepted
    assert standing(find_scene(LINE), how, found) == (
        "known limit" if accepted else "unexpected"
    )


@pytest.mark.parametrize("factor", [1.0, 1.015, 0.985, 1.03, 0.97, 1.9, 0.53, 2.5, 0.4])
def test_a_known_limit_has_a_size(factor):
    """As expected within 2 % for a study with the versions that it was measured with, and within a
    factor of two with others, and for one run."""
    how = registry.method("mujoco/euler")
    line = find_scene(LINE)
    known = registry.limits_of("mujoco/euler").sizes[LINE, "mujoco/euler"]
    accepted = 0.5 <= factor <= 2.0
    study = Judgement(
        "not-converging",
        {},
        "",
        errors={known.fine: factor * known.size},
        versions={"mujoco": "3.16.0"},
    )
    assert verdict_is_expected(line, how, study) == accepted
    same = replace(study, versions=registry.limits_of(how.name).measured_with)
    assert verdict_is_expected(line, how, same) == (0.98 <= factor <= 1.02)
    if not accepted:
        assert f"known to be {known.size:.3g}, within a factor of 2" in surprise(
            line, how, study
        )
        assert f"{known.size:.3g}, within 2 %, for these versions" in surprise(line, how, same)
    edge = known.high if factor > 1.0 else known.low
    for step, held in ((known.fine, accepted), (known.fine / 10.0, True)):
        run = Judgement("off-prediction", {}, "", errors={step: factor * edge})
        assert (not run_surprise(line, how, run)) == held
    changed = find_scene(LINE, {"gravity": 9.0})
    assert verdict_is_expected(changed, how, study)  # no size is known of it


def test_a_known_limit_without_a_size_is_unexpected(monkeypatch):
    monkeypatch.setattr(
        expectations, "limits_of", lambda name: replace(registry.limits_of(name), sizes={})
    )
    found = Judgement("not-converging", {}, "", errors={1e-4: 0.1})
    how = registry.method("mujoco/euler")
    assert surprise(find_scene(LINE), how, found).endswith("its size is not known")


def test_every_known_limit_of_the_quick_profile_has_a_size():
    limits = {
        (scene.name, method.name)
        for scene, method in pairs(matching_scenes("*", "quick"), registry.methods())
        if expected(scene.name, method.name).limit
    }
    held = [registry.limits_of(name) for name in registry.built_in()]
    sizes = {pair for of in held for pair in of.sizes}
    assert limits <= sizes | {pair for of in held for pair in of.solvers}
    assert all(expected(*pair).limit for pair in sizes)  # none is left over


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("within", "code"), [("1e-2", 0), ("1e-6", 1)])
def test_an_accuracy_of_ones_own(validate, within, code):
    """Euler's smallest error on this scene lies between the two; that of RK4 far below."""
    found = validate(CONE, "mujoco/euler,ode/rk4", ("--within", within))
    assert found.code == code
    assert found.failure(CONE, "ode/rk4") == ""
    failure = found.failure(CONE, "mujoco/euler")
    assert failure.startswith(
        "inaccurate, misses the accuracy asked for: the relative error"
    ) == bool(code)
