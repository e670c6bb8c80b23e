"""What the page says of turns, spins and plans is so."""

from __future__ import annotations

from functools import cache

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.study import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.reports.findings import section
from plumbob.reports.findings.capsule_plan import open_loop, path, poses
from plumbob.reports.findings.capsule_plan.plans import SHOWN
from plumbob.reports.findings.capsule_turn import angle, formulas, hard, leak, modes, sag, touching
from plumbob.reports.findings.capsule_turn.runs import turn
from plumbob.reports.view.content import Figure, Finding, Table

EULER, FEET, DEFAULT = "mujoco/euler+coulomb", "pymunk/feet", "mujoco/euler"


@cache
def study(scene: str, methods: tuple[str, ...], *steps: float) -> Study:
    """A scene with some methods at a few steps, and no costs; without steps, not run."""
    chosen, hows = find_scene(scene), [find_method(name) for name in methods]
    convergence = tuple(convergence_study(chosen, how, 100_000, steps) for how in hows if steps)
    return Study(
        "quick", (chosen,), tuple(hows), convergence, {}, 1.0, {"errors": 0.0, "costs": 0.0}
    )


def column(table: Table, head: int | str, key: int = 0) -> dict[str, str]:
    """Texts of a column by the text of their rows' `key`."""
    place = head if isinstance(head, int) else table.heads.index(head)
    return {line[key].text: line[place].text for line in table.rows}


def known(found: Finding | None) -> Finding:
    assert found is not None
    return found


def test_second_order_of_the_formula() -> None:
    found = formulas.finding()
    assert "1.1202033" in found.summary
    assert "1.9032533" in found.summary
    checks, errors = found.tables
    assert all(abs(float(line[3].text)) < 1e-8 for line in checks.rows)
    assert len(checks.rows) == 4
    slopes = {head: float(errors.rows[-1][n].text) for n, head in enumerate(errors.heads) if n}
    assert slopes["eq. 32 at 2τ"] == pytest.approx(2.0, abs=0.02)
    assert slopes["corrected at 2τ"] == pytest.approx(4.0, abs=0.02)
    assert slopes["eq. 32 at rest"] == pytest.approx(2.0, abs=0.02)
    # a fourth order with a logarithm, whose factor theory has as -2.3733 (analytic/README.md)
    assert 3.6 < slopes["corrected at rest"] < 3.9
    seen = formulas.logarithm(formulas.formula_errors().corrected_rest)
    assert seen == pytest.approx(-2.3733, rel=2e-3)


def test_angle_and_the_bar() -> None:
    found = known(angle.finding(study("capsule-turn/0.3", (EULER,))))
    (table,) = found.tables
    met = {(line[0].text, line[1].text): line[-2].text for line in table.rows}
    for epsilon in ("0.3", "0.03"):
        assert met[epsilon, "mujoco/rk4+coulomb"] == met[epsilon, FEET] == "met"
        assert met[epsilon, EULER] == met[epsilon, DEFAULT] == "not met"
    for plot in found.figures:  # two formulas, four methods, and Euler's step where it is predicted
        names = [str(trace["name"]) for trace in plot.traces]
        assert sum("slope" in name for name in names) == 2
        assert {EULER, FEET, DEFAULT} <= set(names)


def test_leak() -> None:
    (table,) = known(leak.finding(study("capsule-turn/0.3", (EULER,)))).tables
    small = column(table, "ε = 0.03")
    assert float(small[EULER]) == pytest.approx(1.0, abs=6e-3)  # friction, and the step's square
    assert all(abs(float(small[name])) < 3e-3 for name in small if name != EULER)


def test_sag() -> None:
    step = turn(0.03).half_time / 800
    measured = study("capsule-turn/0.03", (EULER, DEFAULT), step)
    found = known(sag.finding(measured))
    (table,) = found.tables
    good, bad = ({head: float(cell.text.replace("–", "nan")) for head, cell
                  in zip(table.heads, line, strict=True) if head not in ("method",)}
                 for line in table.rows)  # fmt: skip
    heave, beyond = table.heads[3:5]
    assert good[heave] < 1e-14 < 1e-3 < bad[heave]
    assert abs(good[beyond]) < good["bound of it by sag [rad]"] < 1e-7
    assert bad[beyond] > 1e-3
    assert sag.finding(study("capsule-turn/0.03", (EULER,))) is None


def test_a_support_that_stops_and_leaves() -> None:
    motion = touching.motion()
    ((time, support),) = touching.touches(motion)
    assert time / 0.08 == pytest.approx(1.307, abs=1e-3)
    found = touching.finding()
    assert f"A{support + 1}" in found.summary
    before, after = (
        [float(line[n].text) for line in found.tables[0].rows] for n in (3, 4)
    )  # speed over time: down to nothing and up again, at rates of their own
    assert before[0] == pytest.approx(before[1], rel=1e-2)
    assert after[0] == pytest.approx(after[1], rel=1e-2)
    assert before[0] > 1.5 * after[0] > 0.0


def test_modes_of_a_motion_that_pivots() -> None:
    name = "capsule-turn/pivot"
    scene = find_scene(name)
    motion = system_of(scene).problem(scene.parameters).motion
    strip, slips = modes.figures(motion.single, motion.manoeuvre.half_time)
    assert strip.caption.count("pivot about A2") == 3
    assert strip.caption.endswith("rest.")
    lowest = {t["name"]: min(t["y"]) for t in slips.traces}
    assert lowest["A2"] == pytest.approx(modes.NEAR)
    tau = motion.manoeuvre.half_time
    shown = hard.hard(study(name, (EULER, FEET), tau / 50), scene)
    assert sum(isinstance(one, Figure) for one in shown) == 2
    ends = shown[-1]
    assert isinstance(ends, Table)
    told, end = column(ends, "predicted [rad]"), column(ends, "at the finest [rad]")
    for method in (EULER, FEET):
        assert float(end[method]) == pytest.approx(float(told[method]), rel=0.02)


def test_spin() -> None:
    steps = (1e-3, 5e-4, 2e-4, 1e-4)
    own = section("capsule-coast")
    assert own is not None
    measured = study("capsule-coast/spin", (EULER, DEFAULT), *steps)
    found = next(f for f in own.findings(measured) if f.name == "capsule-spin")
    leads, default = found.tables
    for place in range(1, len(steps) + 1):  # of first order over a decade
        assert float(column(leads, place)[EULER]) == pytest.approx(-2.191, rel=2e-3)
    for line in default.rows:
        heading, rate, missing = (float(cell.text) for cell in line[1:])
        assert 5e-3 < abs(heading) < 3e-2
        assert 1e-2 < rate < 0.5
        assert missing > 0.5


def test_plans(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(open_loop, "QUICK", (FEET,))
    given = study(SHOWN, (FEET,))
    (table,) = known(poses.finding(given)).tables
    (line,) = (dict(zip(table.heads, row, strict=True)) for row in table.rows)
    assert float(line["reference off by [m]"].text) < 1e-6
    assert float(line["naive over best"].text) > 1.3
    _, drawn = path.gallery(SHOWN)
    assert len(drawn) == 3
    found = known(open_loop.finding(given))
    for row in found.tables[0].rows:
        distance, slow = float(row[2].text), float(row[-2].text)
        assert distance < 2e-4
        assert slow < 1e-4 * distance
    assert poses.finding(study("capsule-turn/0.3", (EULER,))) is None
