"""Settings for a wanted contact: MuJoCo rebounds, rests and creeps as they say, at any mass."""

import json
import math

import mujoco
import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.impacts import soft_impact
from plumbob.analytic.errors.contact_models.wanted_contacts import IMPACT_PHASES, rebounds
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import WantedContact
from plumbob.engines.adapters.mujoco.settings_for_contacts import (
    DEFAULT_GRAVITY,
    contact_settings,
)
from plumbob.reports.cli import main

MASSES = (1e-3, 0.05, 1.0, 20.0, 1e3)
STEPS = (5e-4, 1e-3, 4e-3)
# A solver ends with a relative error of 1e-8, and the extremes of 64 and of 1024 moments of an
# impact differ by 1e-3.
BETWEEN_PHASES = 2e-3
DEPTH = 1e-6  # relative: what the exponential approach to rest leaves after 2 s
CREEP = 0.01  # relative: the impedance at the depth of a settled body


def settings(name, value, step, **more):
    given = {"speed": 1.0, "mass": None, "load": None, **more}
    return contact_settings(WantedContact(name=name, value=value, step=step, **given))


def model_with(mjcf, mass, body="<freejoint/>", friction=1.0):
    text = (
        f"<mujoco>{mjcf}<worldbody><geom name='floor' type='plane' size='5 5 1'/>"
        f"<body name='ball' pos='0 0 .1'>{body}<geom name='ball' type='sphere' size='.1' "
        f"mass='{mass}' friction='{friction}'/></body></worldbody></mujoco>"
    )
    return mujoco.MjModel.from_xml_string(text)


def restitutions(model, speed, phases):
    """The speed after an impact over the speed before it, by the moment within a step."""
    data = mujoco.MjData(model)
    ratios = []
    for phase in phases:
        mujoco.mj_resetData(model, data)
        height = phase * speed * model.opt.timestep
        data.qpos[2] = 0.1 + height
        data.qvel[2] = -math.sqrt(speed**2 - 2.0 * DEFAULT_GRAVITY * height)
        touched = False
        for _ in range(400):
            mujoco.mj_step(model, data)
            z = data.qpos[2] - 0.1
            touched |= z < 0.0
            if touched and z >= 0.0:
                break
        ratios.append(
            math.sqrt(data.qvel[2] ** 2 + 2.0 * DEFAULT_GRAVITY * max(z, 0.0)) / speed
        )
    return ratios


@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
def test_a_ball_rebounds_as_the_settings_say(restitution):
    for step in STEPS:
        wanted = settings("restitution", restitution, step)
        width = wanted.high - wanted.low
        assert wanted.low < restitution < wanted.high
        seen = []
        for mass in MASSES:
            seen += restitutions(model_with(wanted.mjcf, mass), 1.0, np.linspace(0.02, 0.9, 12))
        assert min(seen) > wanted.low - BETWEEN_PHASES
        assert max(seen) < wanted.high + BETWEEN_PHASES
        # The range is not wider than the moments within a step make it.
        assert max(seen) - min(seen) > 0.8 * width


def test_the_restitution_of_a_fine_step_is_the_continuous_one():
    # Each impact has an error that depends on its moment within a step, and gravity adds to the
    # error of slow impacts. The mean over the moments of a fast impact has neither error.
    impact = soft_impact(0.8, 1e-3)
    outcome, _ = rebounds(impact, 100.0, 1e-3, DEFAULT_GRAVITY)
    assert len(outcome) == IMPACT_PHASES
    assert outcome.mean() == pytest.approx(0.8, abs=5e-3)


@pytest.mark.parametrize("depth", [1e-6, 1e-4, 5e-3])
def test_a_body_rests_as_deep_as_the_settings_say(depth):
    for step, mass in zip((1e-3, 2e-3, 5e-3), (1e-3, 1.0, 1e3), strict=True):
        wanted = settings("penetration", depth, step)
        model = model_with(wanted.mjcf, mass)
        data = mujoco.MjData(model)
        data.qpos[2] -= depth
        mujoco.mj_step(model, data, round(2.0 / step))
        assert wanted.high == pytest.approx(depth, rel=1e-9)
        assert 0.1 - data.qpos[2] == pytest.approx(depth, rel=DEPTH)


def test_a_load_rests_deeper():
    bare, loaded = (
        settings("penetration", 1e-4, 1e-3, mass=2.0, load=f) for f in (2 * 9.81, 1e3)
    )
    assert bare.mjcf == settings("penetration", 1e-4, 1e-3).mjcf
    assert loaded.push == 500.0
    model = model_with(loaded.mjcf, 2.0)
    data = mujoco.MjData(model)
    data.xfrc_applied[1, 2] = -1e3 + 2 * 9.81
    data.qpos[2] -= 1e-4
    mujoco.mj_step(model, data, 2000)
    assert 0.1 - data.qpos[2] == pytest.approx(1e-4, rel=DEPTH)


SLIDES = (
    "<joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/><joint type='slide'/>"
)


@pytest.mark.parametrize("creep", [1e-3, 1e-6, 1e-9])
def test_a_body_creeps_as_the_settings_say(creep):
    for step, mass in zip((1e-3, 2e-3, 5e-3), (1e-2, 1.0, 50.0), strict=True):
        wanted = settings("creep", creep, step)
        assert wanted.high <= creep * (1.0 + 1e-9)
        model = model_with(wanted.mjcf, mass, body=SLIDES, friction=2.0)
        data = mujoco.MjData(model)
        data.qpos[2] = -wanted.depth
        data.xfrc_applied[1, 0] = mass * DEFAULT_GRAVITY
        mujoco.mj_step(model, data, round(2.0 / step))
        assert data.qvel[0] == pytest.approx(wanted.high, rel=CREEP)


def test_what_is_pasted_quotes_the_names_of_geoms(tmp_path, capsys):
    path = tmp_path / "my.xml"
    path.write_text(
        "<mujoco><worldbody><geom name='a\"b&lt;c&amp;d' type='plane' size='1 1 1'/>"
        "<body><freejoint/><geom name='ball' size='.1'/></body></worldbody></mujoco>"
    )
    words = ["--pair", "ball", 'a"b<c&d', "--creep", "1e-6", "--json"]
    assert main(["settings", "for", str(path), *words]) == 0
    pasted = json.loads(capsys.readouterr().out)["mjcf"]
    whole = path.read_text().replace("<mujoco>", f"<mujoco>{pasted}")
    assert mujoco.MjModel.from_xml_string(whole).npair == 1


def test_a_pair_of_a_file_has_its_masses_and_its_friction(tmp_path, capsys):
    path = tmp_path / "my.xml"
    path.write_text(
        "<mujoco><option timestep='5e-3'/><worldbody><geom name='floor' type='plane' "
        "size='5 5 1' friction='.4'/><body pos='0 0 .1'><freejoint/><geom name='ball' size='.1' "
        "mass='2' friction='.7' condim='4'/><geom size='.01' mass='0'/></body></worldbody></mujoco>"
    )
    words = ["settings", "for", str(path), "--pair", "ball", "floor", "--json"]
    assert main([*words, "--penetration", "1e-3", "--load", "100"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["step"] == 5e-3
    assert said["push"] == pytest.approx(50.0)
    assert 'condim="4" friction="0.7 0.7' in said["mjcf"]
    whole = path.read_text().replace("<option timestep='5e-3'/>", said["mjcf"])
    model = mujoco.MjModel.from_xml_string(whole)
    assert model.npair == 1
    for words_of_a_fault, name in (
        (["--pair", "ball", "flor", "--creep", "1e-6"], "flor"),
        (["--pair", "floor", "floor", "--creep", "1e-6"], "geoms of which one can move"),
        (["--creep", "1e-6"], "pair"),
        (["--pair", "ball", "floor"], "--restitution, --penetration, --creep"),
        (["--pair", "ball", "floor", "--creep", "1e-6", "--mass", "2"], "mass"),
        (["--pair", "ball", "floor", "--creep", "1e-6", "--speed", "2"], "speed"),
    ):
        assert main(["settings", "for", str(path), *words_of_a_fault]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert name in line


@pytest.mark.parametrize(
    ("name", "value"),
    [("restitution", 0.995), ("penetration", 1e-12), ("creep", 1e-18), ("restitution", 1e-3)],
)
def test_what_no_contact_can_have_is_refused(name, value):
    with pytest.raises(ParameterError, match=name):
        settings(name, value, 1e-3)


def test_a_wanted_property_is_not_for_a_method(capsys):
    assert main(["settings", "mujoco/rk4", "--step", "1e-3", "--creep", "1e-6"]) == 2
    assert "settings for" in capsys.readouterr().err
    assert main(["settings", "for", "--creep", "1e-6"]) == 2
    assert "step" in capsys.readouterr().err
