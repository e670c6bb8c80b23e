"""A model file where commands take a scene: numbers of the audit, an engine that builds the file
beside MuJoCo's step of its scheme, derivatives beside differences, and exit codes."""

import json

import mujoco
import numpy as np
import pytest

from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.registry import engines, find_engine, installed
from plumbob.reports.cli import main

ARM = """<mujoco model="arm"><compiler settotalmass="3"/><option timestep="0.001"/>
<worldbody><body name="upper" pos="0 0 1">
  <joint name="shoulder" axis="0 1 0" damping="0.3"/>
  <inertial pos="0.05 0 -0.2" mass="1" diaginertia="0.02 0.02 0.005"/>
  <body name="lower" pos="0 0 -0.4"><joint axis="0.6 0.8 0" stiffness="2"/>
    <inertial pos="0.02 0 -0.15" mass="0.5" fullinertia="0.03 0.03 0.03 0.002 0.006 0.003"/></body>
</body></worldbody>
<actuator><motor name="motor" joint="shoulder" gear="3"/></actuator></mujoco>"""
# By the engine's method: MuJoCo's of the same scheme, and what the file says of dampers.
SAME_SCHEME = {
    "drake/default": ("mujoco/euler", ""),
    "dart/default": ("mujoco/discrete", ""),
    "pinocchio/aba+euler": ("mujoco/euler", '<flag eulerdamp="disable"/>'),
    "pybullet/default": ("mujoco/euler", '<flag eulerdamp="disable"/>'),
}
# Relative: the same update of hinges in double precision, over 100 steps. A gear that is 1e-6
# wrong changes the error by 2e-7 of its size.
SAME = 1e-9
MOTION = ("--ctrl", "sines", "--duration", "0.2")
OF = "joint 0 of body lower"  # it has no name
EPS = 1e-4
# Relative: what rounding leaves of a difference by 1e-7, the smallest of them, is 2e-9. Derivatives
# of the continuous motion are 4e-5 and more away.
APART = 1e-6
OPTION = '<option timestep="0.001"'
MODEL = "plumbob.engines.adapters.mujoco.own_model.model"


def answer(capsys, *words, code=0):
    """What a command prints as JSON about a model file on MOTION."""
    assert main([*words, *MOTION, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def model(folder, old="", new="", gear=3):
    """The path of an arm's file, in which one text stands for another."""
    text = ARM.replace('gear="3"', f'gear="{gear}"')
    assert old in text
    (file := folder / "arm.xml").write_text(text.replace(old, new, 1), "utf-8")
    return str(file)


@pytest.fixture(autouse=True)
def _few(monkeypatch):
    """Fewer runs than an audit makes, for the sake of time."""
    monkeypatch.setattr(f"{MODEL}.OFFERED", ("euler", "rk4"))
    monkeypatch.setattr("plumbob.engines.audit.step_errors.HALVINGS", 2)


def test_numbers_are_those_of_the_audit(tmp_path, capsys):
    """The spring makes Euler's step unstable from 3.4 ms on: 2 sqrt(I/k) with I = 0.059 kg m^2."""
    file = model(tmp_path, 'stiffness="2"', 'stiffness="2e4"')
    audit = answer(capsys, "audit", file)
    known = {name: audit[name] for name in ("certified_until", "uncertainty", "control_period")}
    errors = {(step["integrator"], step["step"]): step["error"] for step in audit["steps"]}
    own = answer(capsys, "run", file)
    assert own["method"] == f"mujoco/{audit['integrator']}"
    assert own["error_over_time"] == audit["error_over_time"]
    same = ("step", "error", "resolved", "worst_body")
    assert {name: own[name] for name in same} == {name: audit[name] for name in same}
    finer = answer(capsys, "run", file, "mujoco/rk4", "--step", "5e-4")
    assert finer["error"] == errors["rk4", 5e-4]
    wanted = 0.4 * own["error"]
    asked = answer(capsys, "recommend", file, "--error", str(wanted))
    choice = asked["choice"]
    assert choice["error"] == errors[choice["integrator"], choice["step"]] <= wanted
    options = {"integrator": "Euler", "timestep": "0.001"} | choice["options"]
    assert options["integrator"].lower() == choice["integrator"]
    assert float(options["timestep"]) == choice["step"]
    limits = answer(capsys, "stability", file, "mujoco/euler", "mujoco/rk4")
    assert limits["stability"] == audit["stability"][:2]
    assert limits["stability"][0]["largest_step"] == pytest.approx(3.4e-3, rel=0.02)
    assert limits["remedies"] == audit["remedies"]
    for row in (own, finer, asked, limits):
        assert {name: row[name] for name in known} == known


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("method", SAME_SCHEME)
def test_an_engine_that_builds_the_file_has_the_error_of_mujocos_scheme(
    method, tmp_path, capsys
):
    if not installed(find_engine(method.partition("/")[0])):
        pytest.skip("the engine is not installed")
    other, flag = SAME_SCHEME[method]
    file = model(tmp_path, f"{OPTION}/>", f"{OPTION}>{flag}</option>")
    built, same = (
        answer(capsys, "run", file, name, "--step", "0.002") for name in (method, other)
    )
    assert built["error"] == pytest.approx(same["error"], rel=SAME)
    assert built["worst_body"] == same["worst_body"]


def test_a_wrong_gear_shows(tmp_path, capsys):
    right, wrong = (
        answer(capsys, "run", model(tmp_path, gear=gear), "mujoco/euler")["error"]
        for gear in (3, 3.000003)
    )
    assert wrong != pytest.approx(right, rel=SAME)


def test_each_engine_that_builds_mechanisms_names_a_method_of_its_own():
    builders = [e for e in engines().values() if e.ability(BuildsMechanisms)]
    named = {e.ability(BuildsMechanisms).method: [m.name for m in e.methods] for e in builders}
    assert {*named} == {*SAME_SCHEME}
    assert all(name in methods for name, methods in named.items())


def test_derivatives_are_differences_of_mujocos_own_runs(tmp_path, capsys):
    """Those that are listed first are among those that are asked for by name."""
    file = model(tmp_path)
    asked = ["gradient", file, "--duration", "0.2", "--json"]
    assert main(asked) == 0
    every = json.loads(capsys.readouterr().out)["gradient"]
    assert main([*asked, "--of", OF, "--by", "motor,velocity"]) == 0
    rows = json.loads(capsys.readouterr().out)["gradient"]
    by = ["control motor", "velocity shoulder", f"velocity {OF}"]
    assert [row["by"] for row in rows] == [name for name in by for _ in range(3)]
    listed = [row for row in every if row["of"] == OF and row["by"] in by]
    assert len(listed) > 2
    assert all(row in rows for row in listed)
    differences = [(ended(file, n, EPS) - ended(file, n, -EPS)) / (2.0 * EPS) for n in range(3)]
    for k, difference in enumerate(differences):
        for row in rows[3 * k : 3 * k + 3]:
            assert row["computed"] == pytest.approx(difference, rel=APART)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("method", [name for name in SAME_SCHEME])
def test_derivatives_in_an_engine_that_builds_the_file_are_those_of_mujocos_scheme(
    method, tmp_path, capsys
):
    if not installed(find_engine(method.partition("/")[0])):
        pytest.skip("the engine is not installed")
    other, flag = SAME_SCHEME[method]
    file = model(tmp_path, f"{OPTION}/>", f"{OPTION}>{flag}</option>")
    words = ["--of", OF, "--duration", "0.04", "--ctrl", "sines", "--json"]
    answers = []
    for name in (method, other):
        assert main(["gradient", file, name, *words]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    built, same = ({row["by"]: row for row in a["gradient"][::-1]} for a in answers)
    assert answers[0]["method"] == method
    assert {*answers[0]["gradient_ways"]} >= {"product", "central", "forward"}
    assert {*built} == {*same}
    for by, row in built.items():
        assert row["exact"] == same[by]["exact"]
        assert row["computed"] == pytest.approx(same[by]["computed"], rel=APART)
        relative_error = row["computed"] / row["exact"] - 1.0
        assert row["relative_error"] == pytest.approx(relative_error, abs=1e-12)  # rounding


def ended(file, number, by):
    """The elbow's angle [rad] after 200 steps of MuJoCo's, with one number of a control and two
    velocities moved by so much."""
    model = mujoco.MjModel.from_xml_path(file)
    data = mujoco.MjData(model)
    shift = by * (np.arange(3) == number)
    data.ctrl[:], data.qvel[:] = shift[:1], shift[1:]
    for _ in range(200):
        mujoco.mj_step(model, data)
    return data.qpos[1]


def test_text_says_what_to_paste(tmp_path, capsys):
    file = model(tmp_path)
    assert main(["recommend", file, "--error", "1e-4", *MOTION]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{file}, error within 100 µm over 0.2 s: ")
    assert second.startswith("<option ")
    assert main(["run", file, "mujoco/implicit", *MOTION]) == 0
    assert f"{file} with mujoco/implicit at 1 ms: error " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        ("recommend --error 1e-15", 3, "not decided"),
        ("recommend --error 1e-6", 1, "no integrator and step"),
        ("run drake/default", 3, "pydrake is not installed"),
        ("gradient drake/default", 3, "pydrake is not installed"),
        ("run mujoco/euler --step 4e-3", 1, "no error: diverged within"),
        ("stability mujoco/euler drake/default", 3, "pydrake is not installed"),
        ("stability mujoco/rk4", 0, "along this motion (your 1 ms: "),
        ("stability mujoco/euler", 1, "no: 1 ms is too large; stable up to "),
    ],
)
def test_exit_codes(words, code, says, tmp_path, capsys, monkeypatch):
    """An error that cannot be decided or is missed, an engine that is not there, and a step that is
    too large for the frequency of a spring."""
    for name in ("run", "gradient", "stability"):
        where = f"plumbob.reports.commands.{name}.installed"
        monkeypatch.setattr(where, lambda engine: engine.name != "drake")
    monkeypatch.setattr(f"{MODEL}.OFFERED", ("euler",))
    command, *more = words.split()
    stiffness = 2.0 if code != 1 else 3e5 if command == "stability" else 2e4
    file = model(tmp_path, 'stiffness="2"', f'stiffness="{stiffness}"')
    assert main([command, file, *more, *MOTION]) == code
    said = capsys.readouterr()
    assert says in said.out + said.err
