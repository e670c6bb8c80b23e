"""Statements of the page on the capsule's line, holding, coasting and repeated manoeuvres hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses import capsule_train, mean_speed, section
from plumbob.reports.analyses.capsule_line import (
    contacts,
    displacement,
    drive,
    fidelity,
    hard,
    source,
    source_text,
    tipping,
)
from plumbob.reports.analyses.measurements import LINE, problem
from plumbob.reports.view.content import Finding, Table
from plumbob.tests.support.declared import declared, finding, measured, nothing
from plumbob.tests.support.declared import findings_of as formed_of

METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/side")
EXACT = -0.0055917  # [m], eq. 22 at physics' check values


def study(scene: str, *steps: float) -> Study:
    """A scene with some methods at a few steps, and no costs."""
    return measured(scene, METHODS, *steps)


def column(table: Table, head: str) -> dict[str, float]:
    """Numbers of a column by the text that begins their rows."""
    place = next(i for i, text in enumerate(table.heads) if text.startswith(head))
    shown = {line[0].text: line[place].text for line in table.rows}
    return {name: float(text) for name, text in shown.items() if text != "–"}


def known(found: Finding | None) -> Finding:
    assert found is not None
    return found


def test_figure_of_the_source() -> None:
    ((_, panels),) = source.galleries(declared(nothing(), source.requests))
    assert [len(panel.traces) for panel in panels] == [3, 3, 3]  # exact, and two engines
    v, v_c, x = (panel.traces[0]["y"] for panel in panels)
    assert max(v) == pytest.approx(1.14777, rel=1e-3)
    assert min(v_c) == pytest.approx(-0.17658, rel=1e-3)
    assert x[-1] == pytest.approx(EXACT, rel=1e-3)
    for panel in panels[:2]:  # dots on the curve of that corner, up to its four digits
        assert max(panel.traces[1]["y"], key=abs) == pytest.approx(
            max(panel.traces[0]["y"], key=abs), rel=0.02
        )


def test_misprints() -> None:
    found = source.misprints(declared(nothing(), source.requests))
    assert "-0.196 m/s" in found.summary
    printed, right, seen = (float(line[1].text) for line in found.tables[0].rows)
    assert printed == pytest.approx(-0.1962, rel=1e-2)
    assert right == 0.0
    assert abs(seen) < 5e-3  # t* is inside a step, between whose ends it is interpolated


def test_any_line() -> None:
    (table,) = source.any_line(declared(nothing(), source.requests)).tables
    assert len(table.rows) == 6
    for line in table.rows:
        assert float(line[2].text) == pytest.approx(EXACT, rel=1e-4)
        assert all(float(line[i].text) < 1.2e-4 for i in (3, 5))
        assert all(float(line[i].text) < 1e-6 for i in (4, 6))


def test_errors_and_what_explains_them() -> None:
    found = known(displacement.errors(study(LINE, 1e-3, 1e-4)))
    coarse, fine = (column(found.tables[0], head) for head in ("0.001 s", "1e-4 s"))
    theory = found.tables[0].rows[0][0].text
    for name, most in (("mujoco/euler+reduced", 1.01), ("pymunk/side", 1.01),
                       ("mujoco/euler+coulomb", 1.08)):  # fmt: skip
        assert 0.99 < coarse[name] / coarse[theory] < most
        assert 0.99 < fine[name] / fine[theory] < most
    assert coarse["mujoco/euler"] > 0.02 < fine["mujoco/euler"]
    # the unexplained part: 4 % for the contacts' delay at the coarse step, and the armature
    for line in found.tables[1].rows:
        beyond, *_, left = (float(cell.text) for cell in line[2:])
        assert abs(left) < 0.04 * abs(beyond) + 4e-13
    assert displacement.errors(nothing()) is None


def test_random_steps_are_on_the_parabola() -> None:
    (table,) = known(displacement.sawtooth(declared(nothing(), displacement.requests))).tables
    bare, deflected = (
        column(table, "largest relative distance"),
        column(table, "with contact deflection"),
    )
    assert max(bare[name] for name in bare if "coulomb" not in name) < 1e-3
    assert deflected["mujoco/euler+coulomb"] < 0.05 < bare["mujoco/euler+coulomb"]


def test_contact_chatter() -> None:
    found = known(contacts.chatter(declared(nothing(), contacts.requests)))
    default, good = found.tables[0].rows[:2], found.tables[0].rows[2:]
    assert all(0.15 < float(line[4].text) < 0.4 for line in default)
    assert all(float(line[3].text) > 5e-6 for line in default)
    assert all(float(line[5].text) == 0.0 for line in default)
    assert all(float(line[3].text) < 1e-9 for line in good)
    assert all([cell.text for cell in line[4:]] == ["0", "3", "1", "1"] for line in good)
    assert [len(plot.traces) for plot in found.figures] == [2, 2, 2]


def test_isotropy() -> None:
    (table,) = known(contacts.isotropy(declared(nothing(), contacts.requests))).tables
    spread = column(table, "spread")
    assert spread["mujoco/euler"] > 0.2
    assert max(spread[name] for name in spread if name != "mujoco/euler") < 1e-12


def test_normal_forces() -> None:
    (table,) = known(contacts.normal_forces(declared(nothing(), contacts.requests))).tables
    assert max(column(table, "at rest").values()) < 1e-6
    assert min(column(table, "largest of all").values()) > 1e-4
    assert max(column(table, "with half").values()) < 1e-5


def test_heights() -> None:
    found = known(fidelity.heights(declared(nothing(), fidelity.requests)))
    assert "1.2 N" in found.summary
    rows = {(line[0].text, line[1].text): line for line in found.tables[0].rows}
    for step, most in (("0.001", 3e-4), ("1e-4", 4e-6)):
        low, tall = (float(rows[f"mujoco/euler+{n}", step][2].text) for n in ("coulomb", "tall"))
        assert abs(tall - low) < most


def test_momentum_and_saving() -> None:
    given = declared(nothing(), fidelity.requests)
    (table,) = known(fidelity.momentum(given)).tables
    assert len(table.rows) == 5
    assert max(column(table, "common").values()) < 1e-12
    (table,) = known(fidelity.saving(given)).tables
    # of processor time, 0.3 to 0.5 where it was measured
    assert column(table, "relative to the full")["mujoco/euler+reduced"] < 0.8


def test_what_else_the_source_says_of_lines() -> None:
    found = source_text.finding(study(LINE, 1e-3))
    said = {one.place: one for one in found.statements}
    assert {one.verdict for one in found.statements} == {"holds", "extended"}
    assert "2.5 % with default contacts" in said["(1)"].ours
    assert said["(17), (20), Fig. 2"].ours == "0.03, 0.0633333, 0.1425 s"
    line = problem(LINE).motion
    assert source_text.slope(line) == pytest.approx((2.0, 2.0), abs=1e-12)
    assert source_text.balance(line) < 1e-11

    class Rough(LineManoeuvre):
        """A friction that is not that of the motion."""

        def friction_force(self, times: Array) -> Array:
            return super().friction_force(times) * (1 + 1e-6)

    given = {field.name: getattr(line, field.name) for field in fields(line)}
    assert source_text.balance(Rough(**given)) > 1e-8


def test_stiction_in_the_quick_profile_is_that_of_its_own_step() -> None:
    (found,) = findings_of("capsule-hold", study("capsule-hold/0.999", 2e-3))
    assert found.tables[0].caption.endswith("0.002 s")
    (statement,) = found.statements
    assert "drifts by at most 2.1e-7 m" in statement.ours


def test_hard_case() -> None:
    name = "capsule-line/near-edge"
    numbers, ends = hard(study(name, 1e-3, 5e-4), find_scene(name))
    assert isinstance(numbers, Table)
    assert isinstance(ends, Table)
    assert float(numbers.rows[0][-1].text) == pytest.approx(1e-4 / 0.3, rel=1e-3)
    error, predicted = column(ends, "error of"), column(ends, "predicted")
    reduced = "mujoco/euler+reduced"
    assert error[reduced] == pytest.approx(predicted[reduced], rel=0.02)


def findings_of(system: str, given: Study) -> Sequence[Finding]:
    own = section(system)
    assert own is not None
    return formed_of(own, declared(given, own.requests))


def test_drift_of_stiction() -> None:
    (found,) = findings_of("capsule-hold", study("capsule-hold/0.999", 1e-3))
    text = {line[0].text: [cell.text for cell in line[1:]] for line in found.tables[0].rows}
    assert text["mujoco/euler"] == ["slides", ""]
    drift, speed = map(float, text["mujoco/euler+coulomb"])
    assert drift == pytest.approx(1.05e-7, rel=0.05)
    assert speed == pytest.approx(drift / 10, rel=0.05)
    assert findings_of("capsule-hold", nothing()) == []


def test_repeated_manoeuvres() -> None:
    ran = study("capsule-train/ten", 1e-3)
    found = capsule_train.numbers(ran)
    assert found is not None
    totals = {total.method: total for total in found.totals}
    reduced = totals["mujoco/euler+reduced"]
    assert reduced.error == pytest.approx(reduced.predicted, rel=0.01)
    assert totals["mujoco/euler+coulomb"].error < 1.2e-4
    assert totals["mujoco/euler"].error > 0.02
    costs = {(c.scene, c.method): Cost(1e3, 1e3, 1e3, 1.0, 0.0, 5) for c in ran.convergence}
    timed = finding(capsule_train.TOTAL, replace(ran, costs=costs))
    assert {line[-1].text for line in timed.tables[0].rows} == {"320 µs"}  # 320 steps of 1 µs
    assert findings_of("capsule-train", nothing()) == []


def test_stopping_distance() -> None:
    (found,) = findings_of("capsule-coast", nothing())
    for head in ("measured, step 0.001", "measured, step 1e-4"):
        lead = column(found.tables[0], head)
        assert lead["mujoco/euler+coulomb"] == pytest.approx(-1.0, abs=1e-2)
        assert lead["pymunk/feet"] == pytest.approx(1.0, abs=1e-2)
        assert abs(lead["mujoco/euler"]) > 10.0


def test_what_sizes_an_actuator() -> None:
    found = known(
        drive.finding(declared(measured(LINE, (*METHODS, "pymunk/pivots"), 1e-3), source.requests))
    )
    demands, errors = found.tables
    peaks = column(demands, "peak of")
    assert peaks["line, C–A₁"] == pytest.approx(9.7119, rel=1e-3)
    assert peaks["turn, ε = 0.1"] == pytest.approx(3805.17, rel=1e-3)
    # centripetal force: 1/epsilon^2
    assert peaks["turn, ε = 0.03"] / peaks["turn, ε = 0.1"] == pytest.approx(1 / 0.09, rel=0.01)
    missed, allowed = column(errors, "of it"), column(errors, "model")
    for name in ("mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/side"):
        assert missed[name] < allowed[name] < 5e-3
    assert missed["mujoco/euler"] > 0.1
    # what is said of engines whose friction converges, of which pymunk/pivots is none
    assert missed["pymunk/pivots"] > 1.0
    within = float(found.summary.partition("it is within ")[2].split()[0])
    convergent = [
        f for n, f in missed.items() if n.endswith(("coulomb", "reduced", "feet", "side"))
    ]
    assert within == pytest.approx(max(convergent) / peaks["line, C–A₁"], rel=0.05)
    assert within < 1e-3
    exact, *engines = found.figures[0].traces
    assert len(engines) == 2
    assert max(exact["y"]) == pytest.approx(9.7119, rel=1e-3)
    assert min(exact["y"]) == pytest.approx(-3.06072, rel=1e-3)


def test_the_exact_condition_for_contact_and_beyond() -> None:
    ran = declared(study(LINE, 1e-3), tipping.requests)
    found = known(tipping.finding(ran))
    assert "4.33 times as far" in found.summary
    motions, outside = found.tables
    inside = {line[0].text: (line[1].text, line[2].text) for line in motions.rows}
    assert list(inside.values()) == [("yes", "yes"), ("yes", "no"), ("no", "yes")]
    assert all(float(line[3].text) > 0.0 for line in motions.rows)
    for line in outside.rows:  # eq. 22 holds there as well
        assert abs(float(line[2].text)) < 2e-4
    held, tipped = (ran.recording(one) for one in (tipping.INSIDE, tipping.TIPPED))
    assert held is not None
    assert tipped is not None
    assert held.channels["contacts"].min() == 3
    assert abs(held.channels["vertical_displacement"]).max() < 1e-9
    lifted = tipped.times[np.argmax(tipped.channels["contacts"] < 3)]
    needed = tipping.loads_beyond(tipped.times)[:, 0]
    # a foot leaves the plane when statics asks for a pull, within the contacts' delay
    assert lifted == pytest.approx(tipped.times[np.argmax(needed < 0.0)], abs=2e-3)
    assert tipped.observables["normal_force_1"][-1] == 0.0
    assert tipped.channels["vertical_displacement"][-1] > 1e-4


def test_the_reference_refuses_what_tips() -> None:
    start = find_scene("capsule-line/near-edge").parameters["start"]
    with pytest.raises(
        ParameterError, match=r"^start = .*such that normal_force_1 is .*, not -0.0"
    ):
        case_of(find_scene("capsule-line/near-edge", {"start": start + tipping.BEYOND}))
    # nine tenths of the way to the edge is still inside
    case_of(find_scene("capsule-line/near-edge", {"start": start + 0.9 * 1e-4 / (0.3 / 1.3)}))


def test_engines_at_the_fastest_manoeuvres() -> None:
    ran = declared(measured("capsule-train/ten", mean_speed.METHODS, 1e-3), mean_speed.requests)
    found = mean_speed.numbers(ran)
    assert found is not None
    assert found.limit == pytest.approx(0.054, abs=5e-4)
    assert found.checked < found.pushed < found.limit < found.most
    assert [run.method for run in found.runs] == [*mean_speed.METHODS]
    for run in found.runs:  # contacts that deflect, at the limit of friction
        assert abs(run.error) < 2e-3, run.method
