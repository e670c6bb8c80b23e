"""Findings that reports/analyses/README.md states, compared with fresh runs."""

import re
from pathlib import Path

import numpy as np
import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

FINDINGS = Path(__file__).parents[2] / "reports" / "analyses" / "README.md"
TEXT = " ".join(FINDINGS.read_text("utf-8").split())
DIGITS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
# of a figure of one or two digits; chatter differs by a few per cent between steps
WITHIN = 0.15
DEFAULT = (
    r"is ([\d.]+) % along the axes of the friction pyramid and ([\d.]+) % at 45° to them "
    r"\(the largest error over the run: ([\d.]+) % and ([\d.]+) %\)"
)
COULOMB = r"at the end is ([\d.]+)·10(\S+) at 1 ms and ([\d.]+)·10(\S+) at 0.1 ms"
COULOMB_RUN = r"over the run it is ([\d.]+) % at 1 ms"


def relative(heading, method, step):
    """Error of the displacement at the end, and the largest over the run, over the way."""
    scene = find_scene(f"capsule-line/heading-{heading:03d}")
    case = case_of(scene)
    found, _ = measure(case, find_method(method), step)
    error = found.errors["displacement"]
    way = abs(float(case.reference.observe(np.array([scene.duration]))["displacement"][0]))
    return abs(error.end) / way, error.largest / way


def said(pattern, text=TEXT):
    """The figures that the one place of the text with this pattern gives."""
    (match,) = re.finditer(pattern, text)
    return match.groups()


@pytest.mark.parametrize("step", [2e-3, 1e-3, 1e-4])
def test_default_contacts(step):
    """At any step, as is said; no other heading is better or worse than these two."""
    axis, diagonal, run_axis, run_diagonal = (float(text) / 100 for text in said(DEFAULT))
    for heading, end, largest in ((0, axis, run_axis), (45, diagonal, run_diagonal)):
        found = relative(heading, "mujoco/euler", step)
        assert found == pytest.approx((end, largest), rel=WITHIN)
    assert axis < relative(15, "mujoco/euler", step)[0] < diagonal


@pytest.mark.parametrize("heading", [0, 30, 45])
def test_convergent_contacts(heading):
    first, power, second, smaller = (text.translate(DIGITS) for text in said(COULOMB))
    (run,) = said(COULOMB_RUN)
    for step, figure in ((1e-3, f"{first}e{power}"), (1e-4, f"{second}e{smaller}")):
        end, _ = relative(heading, "mujoco/euler+coulomb", step)
        assert end == pytest.approx(float(figure), rel=WITHIN)
    _, largest = relative(heading, "mujoco/euler+coulomb", 1e-3)
    assert largest == pytest.approx(float(run) / 100, rel=WITHIN)
