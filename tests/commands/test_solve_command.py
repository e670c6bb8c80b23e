"""`plumbob solve` prints the digits that double precision holds, and no others."""

import json
import re

import numpy as np
import pytest

from plumbob.models.registry import case_of, scene, systems
from plumbob.reports.cli import main


def _row(capsys, *words):
    assert main(["solve", *words]) == 0
    return capsys.readouterr().out.splitlines()[-1].replace(" ± ", "±").split()


@pytest.mark.parametrize("time", ["0.5", "20", "1e3", "1e6", "1e15"])
@pytest.mark.parametrize("name", ["cone-pendulum", "simple-pendulum", "capsule-line"])
def test_a_digit_is_printed_where_the_uncertainty_leaves_it(name, time, capsys):
    reference = case_of(scene(name)).reference
    at = np.array([float(time)])
    exact = reference.observe(at)
    allowed = reference.uncertainty(at)
    for text, key in zip(_row(capsys, name, "--times", time)[1:], exact, strict=True):
        value = float(exact[key][0])
        uncertainty = float(allowed[key][0])
        if uncertainty == 0.0 or "±" in text:
            assert uncertainty == 0.0 or 0.1 * abs(value) < uncertainty
            continue
        assert abs(float(text) - value) <= 5.0 * uncertainty  # half of the last place
        mantissa, _, exponent = text.partition("e")
        last = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
        assert 0.999 * uncertainty <= last  # trailing zeros are left out


def test_json_has_every_digit_and_the_uncertainty(capsys):
    assert main(["solve", "cone-pendulum", "--times", "0.5,1e15", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    reference = case_of(scene("cone-pendulum")).reference
    alone = reference.uncertainty(np.array([0.5]))
    for name, values in answer["uncertainty"].items():
        assert values[0] == float(alone[name][0])  # whatever the later time is
        assert answer["observables"][name][0] == float(
            reference.observe(np.array([0.5]))[name][0]
        )


def test_angles_are_the_parameter(capsys):
    """The source's own form: t(theta), p(theta), theta_dot and phase."""
    answer = ["solve", "cone-pendulum", "--angles", "0,3.1,-1"]
    assert main(answer) == 0
    *_, head, start, top, behind = capsys.readouterr().out.splitlines()
    names = ("theta [rad]", "t [s]", "momentum [kg m^2/s]", "theta_dot [rad/s]", "phase [rad]")
    assert [head.find(name) >= 0 for name in names] == [True] * 5
    assert [float(x) for x in start.split()] == [0.0, 0.0, 33.0300217839, 37.0, 0.0]
    time = float(top.split()[1])
    assert behind.split()[1:] == ["never"] * 4
    assert main([*answer, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["by_angle"]["t"][1] == pytest.approx(time, rel=1e-11)
    assert found["by_angle"]["t"][2] is None
    seen = case_of(scene("cone-pendulum")).reference.observe(np.array([time]))
    assert seen["theta"][0] == pytest.approx(3.1, rel=1e-10)
    assert found["also"]["phase"][-1] == pytest.approx(0.5 * found["mean_rate"])


def test_a_fact_is_an_array_where_each_manoeuvre_ends(capsys):
    assert main(["solve", "capsule-plan", "--times", "0"]) == 0
    assert "\n  ends: [0.2" in capsys.readouterr().out


@pytest.mark.parametrize("system", systems())
def test_each_column_has_its_unit(system, capsys):
    assert main(["solve", system, "--times", "0"]) == 0
    *_, heads, _ = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"(?: +\w+ \[(?:1|s|N|(?:m|rad)(?:/s)?)\])+", heads)
