"""`plumbob audit --reproducible`: the motion computed again in other ways, beside what rounding and
the solver's tolerance make; planted differences are beyond, with their term."""

import copy
import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.difference.port_repetitions import port_repetitions
from plumbob.engines.difference.repetitions import (
    Repeater,
    compared_with_band,
    recorded_run,
    start_of,
)
from plumbob.engines.own_motion import ModelVariation
from plumbob.reports.cli import main

BOX = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/>
<body pos="0 0 .049"><freejoint name="free"/><geom name="box" type="box" size=".05 .05 .05"/></body>
<body pos="1 0 .2"><joint name="swing" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/></body></worldbody></mujoco>"""
DURATION = 0.02  # [s] 10 steps


@pytest.fixture
def files(tmp_path, monkeypatch):
    """The present folder, with a model."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box.xml").write_text(BOX)
    return tmp_path


def repeater(text=BOX, duration=DURATION):
    own = own_model(mujoco.MjModel.from_xml_string(text), "model")
    start = start_of(script(own, "sines", duration), own)
    return Repeater(own, start, recorded_run(own, start, "own"), Allowance(60.0))


def varied(repeater, kind="flag", **changes):
    """The repetition of a model in which numbers of the compiled model are multiplied."""
    changed = copy.copy(repeater.model.effective)
    for name, factor in changes.items():
        values = changed.opt.gravity if name == "gravity" else getattr(changed, name)
        values[:] *= factor
    model = replace(repeater.model, effective=changed)
    return repeater.varied(ModelVariation("changed", kind, model, repeater.model))


def test_a_healthy_model_is_reproducible(files, capsys):
    """All ways are rows of the JSON, which tests/conftest.py holds to its schema."""
    words = ["box.xml", "--reproducible", "--duration", str(DURATION), "--json", "--out", "out"]
    assert main(["audit", *words]) == 0
    answer = json.loads(capsys.readouterr().out)
    rows = {row["name"]: row["verdict"] for row in answer["repetitions"]}
    assert answer["reproducible"]
    assert set(rows.values()) <= {"same bits", "within"}
    assert rows["again"] == rows["10 copies on 4 threads"] == "same bits"
    for name in (
        "sparse Jacobian",
        "sparse Jacobian, converged solver",
        "CG solver",
        "sleep on",
    ):
        assert name in rows
    page = (files / "out" / "audit-box-reproducible.html").read_text("utf-8")
    assert "Is the motion of box.xml reproducible?" in page


@pytest.mark.parametrize(
    ("changes", "term"),
    [
        ({"gravity": 1.0 + 1e-9}, "acceleration"),
        ({"geom_contype": 0}, "contact set"),
    ],
)
def test_a_planted_difference_is_beyond_from_its_first_step_on_in_its_term(changes, term):
    row = varied(repeater(), **changes)
    assert (row.verdict, row.steps.term, row.begin) == ("beyond", term, 0.0)
    assert row.factor > 100.0


def test_a_difference_of_a_unit_in_the_last_place_is_within():
    """A factor of 1e-9 above is 1e7 units in the last place, of which ten are allowed."""
    row = varied(repeater(), gravity=1.0 + 2.0**-52)
    assert row.verdict == "within"
    assert 0.0 < row.factor <= 1.0


def test_a_model_that_diverges_is_beyond():
    row = varied(repeater(), gravity=1e12)
    assert row.verdict == "beyond"
    assert "diverges" in row.why


def test_a_solver_row_says_what_its_tolerance_and_iterations_leave():
    """The oracle takes each acceleration by mj_forward, with one iteration and with a thousand."""
    once = repeater()
    changed = copy.copy(once.model.effective)
    changed.opt.solver, changed.opt.iterations = mujoco.mjtSolver.mjSOL_PGS, 1
    model = replace(once.model, effective=changed)
    row = once.varied(ModelVariation("one iteration", "solver", model, once.model))
    assert row.verdict == "within"
    assert (row.solver.iterations, row.solver.at_cap) == (1, row.solver.steps)
    full = copy.copy(changed)
    full.opt.iterations, full.opt.tolerance = 1000, 1e-16
    full.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
    data, other = mujoco.MjData(changed), mujoco.MjData(full)
    largest = 0.0
    for _ in range(row.solver.steps):
        other.qpos[:], other.qvel[:] = data.qpos, data.qvel
        mujoco.mj_step(changed, data)
        mujoco.mj_forward(full, other)
        largest = max(largest, np.abs(data.qacc - other.qacc).max())
    # Euler's step damps implicitly, here nothing: its acceleration is that of mj_forward to
    # rounding, 1e-12 of it.
    assert row.solver.largest == pytest.approx(largest, rel=1e-9)


def test_in_python_it_asserts_and_refuses(files):
    model = mujoco.MjModel.from_xml_string(BOX)
    found = plumbob.audit_reproducible(model, duration=DURATION)
    found.assert_reproducible()
    assert "reproducible" in repr(found)
    bad = replace(found.repetitions[0], diverges=True)
    broken = type(found)(**{**vars(found), "repetitions": (bad,)})
    with pytest.raises(AssertionError, match="again"):
        broken.assert_reproducible()
    for words in ({"engines": ["drake"]}, {"duration": -1.0}, {"duration": 1e3}):
        with pytest.raises(ParameterError):
            plumbob.audit_reproducible(model, **words)


def test_time_that_is_too_short_leaves_the_answer_open():
    once = repeater()
    once.allowance = Allowance(0.0)
    row = varied(once, gravity=1.0 + 2.0**-52)
    assert (row.verdict, row.steps.checked) == ("open", 0)


@pytest.mark.rare
def test_a_port_in_single_precision_is_within_its_rounding_alone_and_in_a_batch():
    """The bound is that of single precision: in double precision the same run is beyond."""
    pytest.importorskip("mujoco_warp")
    once = repeater(duration=0.1)
    given = (once.model, once.start, once.recording, ["mjwarp"], 60.0, lambda what: None)
    alone, batch = port_repetitions(*given)
    assert (alone.verdict, batch.verdict) == ("within", "same bits")
    assert alone.steps.checked == len(once.start.controls)
    states = once.recording.states.copy()
    states[1:] += alone.end
    assert compared_with_band(once.band, "moved", "port", states).verdict == "beyond"
