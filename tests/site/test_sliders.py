"""Figures that answer, driven in Chromium, against the closed forms in Python."""

import json
import shlex

import numpy as np
import pytest

from plumbob.models.registry import case_of, scene
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import site_files

# of a value's size: integrals are refined to 1e-13; rounding grows at a turning point
NEAR = 1e-9
SET = """(values) => {
  const section = document.querySelector(".sliders");
  for (const [name, value] of Object.entries(values)) {
    const input = section.querySelector(`[name=${name}]`);
    input.value = value;
    input.dispatchEvent(new Event("input"));
  }
  return {answer: section.answer, command: section.querySelector(".command code").textContent,
    said: section.querySelector("[role=status]").textContent,
    panels: section.querySelectorAll(".panels svg").length,
    axis: getComputedStyle(section.querySelector(".panels .a")).fill,
    energy: section.querySelector(".panels text:last-of-type").textContent};
}"""


@pytest.fixture(scope="module")
def visit(index, browser):
    with visited(browser, index) as there:
        yield there
        assert there.console == []


def moved(visit, index, system, values):
    """The figure of a system with sliders moved."""
    visit.page.goto((site_files(index)[1].parent / f"{system}.html").as_uri())
    shown = visit.ask(SET, values)
    return shown


def repeated(command):
    """The case of the command that repeats a figure, and what it sets."""
    _, _, name, *words = shlex.split(command)
    changes = {k: json.loads(v) for k, _, v in (w.partition("=") for w in words if "=" in w)}
    return case_of(scene(name, changes)), changes


@pytest.mark.long
@pytest.mark.parametrize(
    ("system", "values", "kind"),
    [
        ("cone-pendulum", {"theta_dot": 0.7, "theta": 1.31, "platform_rate": 3.7}, "Libration"),
        (
            "cone-pendulum",
            {"com_distance": 0.301, "pivot_y": -0.213, "theta_dot": -55.3},
            "Rotation",
        ),
        ("cone-pendulum", {"platform_rate": 17.3, "pivot_y": 0, "theta_dot": 2.2}, "Libration"),
        ("simple-pendulum", {"theta": 2.93, "theta_dot": 0.3, "length": 0.47}, "Libration"),
        ("simple-pendulum", {"theta": -1.27, "theta_dot": -11.3}, "Rotation"),
        ("simple-pendulum", {"theta": 0.03}, "Libration"),
    ],
)
def test_a_pendulum_moves_as_the_closed_form_says(visit, index, system, values, kind):
    shown = moved(visit, index, system, values)
    case, changes = repeated(shown["command"])
    assert {k: v for k, v in values.items() if k != "com_distance"}.items() <= changes.items()
    answer = shown["answer"]
    exact = case.reference.observe(np.array(answer["time"]))
    for name, key in (("theta", "theta"), ("theta_dot", "speed")):
        size = np.abs(exact[name]).max()
        assert np.abs(np.array(answer[key]) - exact[name]).max() <= NEAR * size, name
    assert answer["time"][-1] == answer["period"]
    turned = np.remainder(exact["theta"][-1] - exact["theta"][0] + np.pi, 2 * np.pi) - np.pi
    assert abs(turned) <= 10 * NEAR
    assert shown["said"].startswith(kind)
    assert shown["panels"] == 4
    assert shown["axis"] == "none"
    unit = {"cone-pendulum": "J", "simple-pendulum": "J/kg"}[system]
    assert shown["energy"] == f"V [{unit}]"
    assert f" {unit}," in shown["said"]


@pytest.mark.long
@pytest.mark.parametrize(
    "values",
    [
        {"w1": 71.3, "t1": 0.017, "friction": 0.33},
        {"slider_mass": 0.91, "body_mass": 1.7, "w1": 20.3, "w2": 7.9},
        {"w2": 3.3, "t1": 0.051},
    ],
)
def test_the_line_moves_as_the_closed_form_says(visit, index, values):
    shown = moved(visit, index, "capsule-line", values)
    case, changes = repeated(shown["command"])
    assert changes == values
    answer = shown["answer"]
    line = case.problem.motion
    for name in ("displacement", "t_star", "t2", "stroke"):
        assert answer[name] == pytest.approx(getattr(line, name), rel=NEAR), name
    exact = case.reference.observe(np.array(answer["time"]))
    for name, key in (("displacement", "place"), ("velocity", "speed")):
        size = np.abs(exact[name]).max()
        assert np.abs(np.array(answer[key]) - exact[name]).max() <= NEAR * size, name


@pytest.mark.long
@pytest.mark.parametrize(
    "values",
    [
        {"damping_rate": 0.17, "theta": 2.1, "theta_dot": -7.3},
        {
            "damping_rate": 0.31,
            "forcing_amplitude": 3.7,
            "forcing_frequency": 2.9,
            "length": 0.7,
        },
        {"forcing_amplitude": 0.4, "forcing_frequency": 1.3, "theta": 0.2},
    ],
)
def test_a_driven_pendulum_moves_as_in_python(visit, index, values):
    shown = moved(visit, index, "simple-pendulum", values)
    case, changes = repeated(shown["command"])
    assert changes == values
    answer = shown["answer"]
    exact = case.reference.observe(np.array(answer["time"]))
    assert answer["time"][-1] == pytest.approx(50.0)
    for name, key in (("theta", "theta"), ("theta_dot", "speed")):
        size = np.abs(exact[name]).max()
        assert np.abs(np.array(answer[key]) - exact[name]).max() <= NEAR * size, name


@pytest.mark.long
@pytest.mark.parametrize("epsilon", [0.037, 0.223, 0.417, 0.861])
def test_a_turn_ends_as_its_exact_motion_does(visit, index, epsilon):
    """Within what the page says of the table, and eq. 32's next term as Python has it."""
    shown = moved(visit, index, "capsule-turn", {"epsilon": epsilon})
    case, _ = repeated(shown["command"])
    facts = case.system.facts(case.problem)
    assert facts["epsilon"] == pytest.approx(epsilon, rel=1e-12)
    answer = shown["answer"]
    for key, name in (("stop", ""), ("rest", "_at_rest")):
        assert answer[key]["now"] == pytest.approx(facts[f"body_angle{name}"], abs=1e-5)
        assert answer[key]["next"] == pytest.approx(
            facts[f"body_angle_corrected{name}"], abs=1e-5
        )
    assert shown["panels"] == 2
