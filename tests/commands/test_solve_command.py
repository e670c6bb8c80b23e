"""`plumbob solve` prints the digits that double precision holds, and no others."""

from __future__ import annotations

import json

import numpy as np
import pytest

from plumbob.models.registry import case_of, scene, scenes, systems
from plumbob.reports.cli import main


def _row(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert main(["solve", *words]) == 0
    return capsys.readouterr().out.splitlines()[-1].replace(" ± ", "±").split()


def test_a_time_that_leaves_no_digit(capsys: pytest.CaptureFixture[str]) -> None:
    time, *values = _row(capsys, "cone-pendulum", "--times", "0.5,1e15")
    assert float(time) == 1e15
    assert len(values) == 2
    for text in values:
        value, _, uncertainty = text.partition("±")
        assert float(uncertainty) > 0.1 * abs(float(value))


@pytest.mark.parametrize("time", ["0.5", "20", "1e3", "1e6"])
@pytest.mark.parametrize("name", ["cone-pendulum", "simple-pendulum", "capsule-line"])
def test_a_digit_is_printed_where_the_uncertainty_leaves_it(
    name: str, time: str, capsys: pytest.CaptureFixture[str]
) -> None:
    reference = case_of(scene(name)).reference
    at = np.array([float(time)])
    exact, allowed = reference.observe(at), reference.uncertainty(at)
    for text, key in zip(_row(capsys, name, "--times", time)[1:], exact, strict=True):
        value, uncertainty = float(exact[key][0]), float(allowed[key][0])
        if uncertainty == 0.0 or "±" in text:
            assert uncertainty == 0.0 or 0.1 * abs(value) < uncertainty
            continue
        assert abs(float(text) - value) <= 5.0 * uncertainty  # half of the last place
        mantissa, _, exponent = text.partition("e")
        last = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
        assert 0.999 * uncertainty <= last  # trailing zeros are left out


def test_json_has_every_digit_and_the_uncertainty(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", "cone-pendulum", "--times", "0.5,1e15", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    reference = case_of(scene("cone-pendulum")).reference
    alone = reference.uncertainty(np.array([0.5]))
    for name, values in answer["uncertainty"].items():
        assert values[0] == float(alone[name][0])  # whatever the later time is
        assert answer["observables"][name][0] == float(reference.observe(np.array([0.5]))[name][0])


@pytest.mark.parametrize("name", list(systems()))
def test_every_system_is_printed(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    names = case_of(scene(name)).reference.observe(np.zeros(1))
    assert len(_row(capsys, name, "--times", "0.1")) == 1 + len(names)


# Others of capsule-plan take up to ten seconds each to plan: with --profile full.
QUICK_PLANS = ("capsule-plan/near-free", "capsule-plan/ahead-curve")
ALL = [one.name for one in scenes("*")]


@pytest.mark.parametrize("system", list(systems()))
def test_every_scene_is_printed(
    system: str, capsys: pytest.CaptureFixture[str], pytestconfig: pytest.Config
) -> None:
    own = [name for name in ALL if name.startswith(f"{system}/")]
    if system == "capsule-plan" and pytestconfig.getoption("profile") != "full":
        own = [name for name in own if name in QUICK_PLANS]
    assert own
    for name in own:
        case = case_of(scene(name))
        lines = _printed(capsys, name)
        assert lines[0].startswith(f"{name}: {case.scene.summary}")
        facts = [line.strip().partition(":")[0] for line in lines]
        for key, value in case.system.facts(case.problem).items():
            assert key in facts or value in (None, "", [], {}), (name, key)


def _printed(capsys: pytest.CaptureFixture[str], name: str) -> list[str]:
    assert main(["solve", name, "--times", "0.05"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out.splitlines()
