"""The certified answer of every system's default scene against the exact answer, which shares no
code with it: one integrates MuJoCo's model of the scene, the other is a closed form, or integrates
equations of its own.

A tree has nothing that yields. Contacts of MuJoCo's model yield, and tend to rigid ones as the step
that they are for shrinks: the certified answer of rigid contacts is the answer for a quarter of a
step, and the difference from the answer for the whole step is left open. Errors that go as the step
leave a third of that.
A loop's spring and damper have equations in `analytic`, which are integrated here by scipy.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.slider_crank import LOOP
from plumbob.engines.audit.scene_reference import scene_reference, two_answers
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import built_in_systems, case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.cli import main

STEP = 1e-3  # [s]
BUDGET = 60.0  # [s] of processor time: several times what the slowest takes
EULER, COULOMB = "mujoco/euler", "mujoco/euler+coulomb"
# A millionth moves each answer of a tree by more than the two answers state.
FINE = 1e-6
# System: method, longest duration [s], and what must show: a parameter of the exact answer with a
# relative change, or, if the parameters of a body that is held have no effect, or a plan takes long
# to change, another method, whose contacts drift. The quick ones come first.
SYSTEMS = {
    "cone-pendulum": (EULER, 0.5, ("gravity", FINE)),
    "free-body": (EULER, 2.0, ("inertia_x", FINE)),
    "heavy-top": (EULER, 1.0, ("gravity", FINE)),
    "linear-pendulum": (EULER, 2.0, ("length", FINE)),
    "projectile": (EULER, 1.5, ("gravity", FINE)),
    "servo": (EULER, 0.5, ("kp", FINE)),
    "simple-pendulum": (EULER, 2.0, ("gravity", FINE)),
    "rod-impact": (COULOMB, 0.4, ("gravity", 0.05)),
    "capsule-coast": (COULOMB, 0.2, ("friction", 1e-4)),
    "bouncing-ball": (EULER, 1.2, ("gravity", 0.05)),
    "capsule-hold": (COULOMB, 0.3, "mujoco/euler+elliptic"),
    "n-pendulum": (EULER, 1.0, ("gravity", FINE)),
    "rolling-ball": (COULOMB, 1.0, ("gravity", 1e-4)),
    "rolling-disc": (COULOMB, 0.3, ("spin_rate", 1e-3)),
    "incline": (COULOMB, 1.0, ("gravity", 1e-4)),
    "pinch": (COULOMB, 1.0, EULER),
    "stack": ("mujoco/euler+stiff", 1.0, EULER),
    "capsule-line": (COULOMB, 0.14, ("friction", 1e-3)),
    "capsule-turn": (COULOMB, 0.08, ("friction", 0.1)),
    "capsule-train": (COULOMB, 0.4, ("friction", 1e-3)),
    "capsule-plan": (COULOMB, 0.1, "mujoco/euler+elliptic"),
    "four-bar": (EULER, 0.1, ()),
    "slider-crank": (EULER, 0.1, ()),
}
LOOPS = ("four-bar", "slider-crank")
SCIPYS = 2e-11  # [rad, m] of an integration to 1e-12, relative: a tenth of what a loop adds


def certified_scene(name, step=STEP, method=""):
    """The case of a system's default scene, and its certified answer."""
    usual, longest, _ = SYSTEMS[name]
    case = case_of(find_scene(name))
    case = case.lasting(min(case.scene.duration, longest))
    return case, scene_reference(case, find_method(method or usual), step, BUDGET)


def rigid_limit(name):
    """The case of a system's default scene, the certified answer as it is for rigid contacts, and
    {observable: what the contacts leave open}, without what the model declares."""
    case, reference = certified_scene(name)
    if not reference.yields or name in LOOPS:
        return case, reference, {}
    finer = certified_scene(name, STEP / 4.0)[1]
    assert finer.times == pytest.approx(reference.times)  # of durations that are whole periods
    left_open = {
        observable: float(np.abs(values - finer.observables[observable]).max())
        for observable, values in reference.observables.items()
    }
    return case, finer, left_open


def relative_distances(case, reference, left_open):
    """{observable: how far its two answers differ, over what is allowed}."""
    answers = two_answers(case, reference.method, reference.step, reference)
    return {
        name: answer.distance
        / (answer.uncertainty + answer.rounding + answer.model_error + left_open.get(name, 0.0))
        for name, answer in answers.items()
        if answer.distance
    }


def test_every_system_has_a_row():
    assert {*SYSTEMS} == {*built_in_systems()}


@pytest.mark.rare(keep=20)  # without the plan, which takes as long as ten others
@pytest.mark.long(keep=11)
@pytest.mark.parametrize("name", [name for name in SYSTEMS if name not in LOOPS])
def test_certified_answers_are_the_exact_ones(name):
    case, reference, left_open = rigid_limit(name)
    assert reference.times[-1] == pytest.approx(case.scene.duration, abs=STEP)
    assert max(relative_distances(case, reference, left_open).values(), default=0.0) <= 1.0
    changed = changed_pair(name, case, reference)
    assert max(relative_distances(*changed, left_open).values()) > 1.0


def changed_pair(name, case, reference):
    """The case and the certified answer of a system, one of them changed so that the
    change must show."""
    change = SYSTEMS[name][-1]
    if isinstance(change, str):
        drifting = certified_scene(name, STEP, change)[1]
        return case, replace(drifting, method=reference.method, step=reference.step)
    parameter, ratio = change
    value = case.scene.parameters[parameter] * (1.0 + ratio)
    return replace(case_of(find_scene(name, {parameter: value})), scene=case.scene), reference


@pytest.mark.long
@pytest.mark.parametrize("name", LOOPS)
def test_loops_yield_as_their_equations_do(name):
    """Twice as soft a loop is further off than both integrations leave open."""
    case, reference = certified_scene(name)
    assert reference.yields
    exact = case.reference.observe(reference.times)
    soft, softer = (
        softly_closed(case, loop, reference.times)
        for loop in (LOOP, replace(LOOP, impedance=1.0 - 2.0 * (1.0 - LOOP.impedance)))
    )
    for observable in (o.name for o in case.system.observables):
        answer = reference.observables[observable]
        allowed = reference.uncertainty[observable][-1] + SCIPYS
        assert np.abs(answer - soft[observable]).max() <= allowed
        assert np.abs(answer - softer[observable]).max() > allowed
        assert np.abs(answer - exact[observable]).max() > allowed


def softly_closed(case, loop, times):
    """The observables at times [s], shape (n,), of a mechanism whose loop is closed softly."""
    system = case.problem.soft(loop, STEP)
    values = system.values

    def rates(time, state):
        place, speed = np.split(state, 2)
        forces = system.forces(values, time, place, speed)
        return [*speed, *np.linalg.solve(system.mass_matrix(values, place), forces)]

    solved = solve_ivp(
        rates, (0.0, times[-1]), system.start, "DOP853", times, rtol=1e-12, atol=1e-13
    )
    return system.observed(solved.y)


def test_a_run_says_what_the_model_adds_and_what_the_step(capsys):
    """The velocity of a body that slides on soft contacts has an error by their depth: nearly
    all of it is the model's, and hardly any the step's."""
    words = ["run", "capsule-line", COULOMB, "--step", "1e-3", "--certified", "--json"]
    assert main(words) == 0
    answer = json.loads(capsys.readouterr().out)["certified"]
    assert answer["method"] == COULOMB
    assert answer["yields"]
    velocity = answer["observables"]["velocity"]
    assert velocity["error"] < 0.1 * velocity["error_from_exact"]
    assert velocity["distance"] == pytest.approx(velocity["error_from_exact"], rel=0.1)


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        ("cone-pendulum ode/dop853 --step 1e-9", 0, "mujoco/euler at 0.001"),
        (
            "cone-pendulum mujoco/euler --step 1e-3 --set gravity=9.8 --budget 1e-9",
            3,
            "ended at",
        ),
        ("capsule-coast mujoco/euler+coulomb+noslip --step 1e-3", 3, "the noslip solver"),
        ("stack mujoco/euler --step 1e-3", 0, "contacts or loops of that model yield"),
        ("model.xml mujoco/euler", 2, "certified = True: must be left out with a model file"),
    ],
)
def test_exit_codes_of_certified_answers(words, code, says, capsys):
    assert main(["run", *words.split(), "--certified"]) == code
    printed = capsys.readouterr()
    assert says in printed.out + printed.err
    assert printed.err.count("\n") == (code > 0)


def test_a_step_of_which_no_whole_number_makes_a_short_period_is_refused():
    case = case_of(find_scene("cone-pendulum"))
    step = case.scene.duration / 1_000_003  # a prime number of steps
    with pytest.raises(ParameterError, match="100000 periods of"):
        scene_reference(case, find_method("ode/rk4"), step, BUDGET)


def test_a_wrong_exact_answer_ends_with_1(capsys, monkeypatch):
    """The exact answer of a projectile under a millionth more gravity."""
    other = case_of(find_scene("projectile", {"gravity": 9.81 * (1.0 + FINE)}))
    monkeypatch.setattr("plumbob.reports.commands.run.case_of", lambda scene: other)
    words = ["run", "projectile", "ode/rk4", "--step", "1e-2", "--certified", "--json"]
    monkeypatch.setattr(
        "plumbob.engines.audit.scene_reference.scene_reference",
        lambda case, *more: scene_reference(case_of(find_scene("projectile")), *more),
    )
    assert main(words) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "predicted"
    assert not answer["certified"]["within"]
