"""An audit held against an older one: what has moved, and which of it fails."""

import json
import math

import pytest

from plumbob.engines.audit.changes import changes
from plumbob.reports.cli import main
from plumbob.tests.support.first_verdicts import without_first_verdict

ROD = """<mujoco><option timestep="0.005"/><worldbody><body name="rod"><joint axis="0 1 0"/>
<geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>"""
AUDIT = {
    "integrator": "euler",
    "step": 0.005,
    "start": [0.0, 0.0],
    "control": "rest",
    "control_period": 0.02,
    "duration": 1.0,
    "worst_body": "rod",
    "certified_until": 1.0,
    "uncertainty": 1e-6,
    "error": 0.01,
    "error_measure": "corner displacement",
    "error_over_time": [0.002, 0.01],
    "why": "",
    "unstable": False,
    "pose": {"world": [0.0, 0.0, 0.0], "rod": [0.3, 0.0, 0.4]},
    "corners": {"rod": [[0.6, 0.0, 0.8], [0.0, 0.0, 0.0]]},
    "fields": {"opt.timestep": "0.005"},
    "versions": {"mujoco": "3.17.0"},
}


@pytest.mark.parametrize(
    ("new", "what", "growth"),
    [
        (
            {"error_over_time": [0.002, 0.010001]},
            None,
            None,
        ),  # within what both references leave open, 2e-6
        ({"error_over_time": [0.002, 0.0101]}, "error [m]", 0.01),
        ({"error_over_time": [0.002, 0.005]}, "error [m]", -0.5),
        ({"error_over_time": [0.002, None]}, "error [m]", math.inf),  # it diverges
        ({"corners": {"rod": [[0.6, 1e-6, 0.8], [0.0, 0.0, 0.0]]}}, None, None),
        (
            {"corners": {"rod": [[0.6, 2e-3, 0.8], [0.0, 0.0, 0.0]]}},
            "certified rod at 1 s by [m]",
            0.2,
        ),
        # a body of another shape: its centre of mass is compared
        ({"corners": {"rod": [[0.6, 2e-3, 0.8]]}}, None, None),
        (  # as far as both are certified, errors are the same
            {"certified_until": 0.5, "error": 0.002, "error_over_time": [0.002]},
            "certified until [s]",
            math.inf,
        ),
        ({"unstable": True}, "unstable", math.inf),
        ({"step": 0.01}, "step", None),
        ({"duration": 1.0 + 2e-9}, "duration", None),
        ({"duration": 1.0 + 5e-10}, None, None),
        ({"versions": {"mujoco": "4.0.0"}}, "version of mujoco", None),
        ({"fields": {"opt.timestep": "0.01"}}, "field opt.timestep", None),
        ({"fields": {}}, "field opt.timestep", None),
    ],
)
def test_what_moves_beyond_what_is_known(new, what, growth):
    rows = changes(AUDIT, AUDIT | new)
    assert [row.what for row in rows] == ([] if what is None else [what])
    assert [row.growth for row in rows] == pytest.approx([] if what is None else [growth])


@pytest.mark.parametrize(
    ("new", "what", "growth"),
    [
        ({"error": 0.03, "error_over_time": [0.01, 0.03], "worst_body": "other"}, None, None),
        ({"pose": {"rod": [0.3, 1e-3, 0.4]}}, "certified rod at 1 s by [m]", 0.1),
        ({"certified_until": 0.5}, "certified until [s]", None),
        ({"unstable": True}, "unstable", math.inf),
        ({"step": 0.01}, "step", None),
    ],
)
def test_an_older_audit_is_compared_in_what_both_measure_alike(new, what, growth):
    """One without a measure has distances of centres of mass: a line says that errors are not
    compared, and an error that only the new measure sees fails nothing."""
    old = {name: AUDIT[name] for name in AUDIT.keys() - {"error_measure", "corners"}}
    measure, *rows = changes(old, AUDIT | new)
    assert measure.what == "the measure of errors, which are not compared:"
    assert measure.old == "distance of centres of mass"
    assert (measure.new, measure.growth) == ("corner displacement", None)
    assert [row.what for row in rows] == ([] if what is None else [what])
    assert [row.growth for row in rows] == ([] if what is None else [pytest.approx(growth)])


@pytest.mark.long
def test_an_edit_is_named_and_fails_where_asked(tmp_path, capsys):
    file = tmp_path / "rod.xml"
    old = tmp_path / "old.json"
    file.write_text(ROD)
    quick = ["audit", str(file), "--duration", "0.1", "--budget", "5"]
    assert main([*quick, "--json"]) == 0
    old.write_text(capsys.readouterr().out)
    against = [*quick, "--against", str(old), "--fail-above", "5%"]
    assert main(against) == 0
    assert "since then" in (out := capsys.readouterr().out)
    assert "nothing has changed" in out
    file.write_text(ROD.replace("0.005", "0.01").replace("<joint", '<joint damping="0.01"'))
    assert main([*against, "--json"]) == 1
    printed = capsys.readouterr()
    moved = {row["what"]: row for row in json.loads(printed.out)["changes"]}
    assert moved["error [m]"]["growth"] == pytest.approx(1.0, abs=0.02)  # twice the step
    assert {"step", "field opt.timestep", "field dof_damping"} < set(moved)
    assert "certified rod at 0.1 s by [m]" in moved
    assert without_first_verdict(printed.err).count("\n") == 1


@pytest.mark.long
def test_another_control_file_is_named(tmp_path, capsys):
    motor = '<actuator><motor joint="hinge"/></actuator></mujoco>'
    text = ROD.replace("<joint", '<joint name="hinge"').replace("</mujoco>", motor)
    (tmp_path / "rod.xml").write_text(text)
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text(f"0.{ord(name)}\n0.1\n")
    quick = ["audit", str(tmp_path / "rod.xml"), "--budget", "5", "--ctrl"]
    assert main([*quick, str(tmp_path / "a.csv"), "--json"]) == 0
    (tmp_path / "old.json").write_text(capsys.readouterr().out)
    assert main([*quick, str(tmp_path / "b.csv"), "--against", str(tmp_path / "old.json")]) == 0
    assert "control a.csv -> b.csv" in capsys.readouterr().out


@pytest.mark.long
def test_several_find_their_own_and_what_is_no_audit_is_one_line(tmp_path, capsys):
    for name in ("a", "b"):
        (tmp_path / f"{name}.xml").write_text(ROD)
    old = tmp_path / "old.json"
    paths = [str(tmp_path / f"{n}.xml") for n in ("a", "b")]
    stored = [{**AUDIT, "model": path, "error_over_time": [0.0, 0.5, 1.0]} for path in paths]
    old.write_text(
        json.dumps(
            [{**stored[0], "error_over_time": [0.0, 0.0, 1e-9], "uncertainty": 0.0}, stored[1]]
        )
    )
    words = [str(tmp_path), "--duration", "0.04", "--budget", "5", "--against", str(old)]
    assert main(["audit", *words, "--fail-above", "5%"]) == 1
    err = capsys.readouterr().err
    assert (err.count("a.xml: error at 0.04 s"), err.count("b.xml: error")) == (1, 0)
    assert main(["audit", *words, "--contacts"]) == 2
    old.write_text(json.dumps({**AUDIT, "model": "c"}))
    assert main(["audit", *words]) == 2
    for text in ("{", "[1]", '{"model": "a"}', "[" * 100_000):
        old.write_text(text)
        capsys.readouterr()
        assert main(["audit", *words]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert main(["audit", str(tmp_path), "--fail-above", "5%"]) == 2
