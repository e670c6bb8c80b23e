"""`plumbob settings` on the command line: what it prints, and what it finds in a model file."""

import json
import re

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.contacts import coulomb_pair
from plumbob.engines.registry import engines
from plumbob.models.registry import systems
from plumbob.models.tripod_capsule.parameters import CHECK
from plumbob.reports.cli import main

METHOD = "mujoco/euler+coulomb"
CAPSULE = systems()["capsule-line"].mjcf
WRITTEN = [m.name for m in engines()["mujoco"].methods if "reduced" not in m.name]


def _run(capsys, *words):
    code = main(["settings", *words])
    out, err = capsys.readouterr()
    return code, out, err


def _check(capsys, path, *words):
    code, out, _ = _run(capsys, *words, "--check", str(path), "--json")
    return code, json.loads(out)


@pytest.mark.parametrize("method", WRITTEN)
def test_text_and_json_agree(method, capsys):
    code, text, _ = _run(capsys, method, "--step", "1e-3")
    assert code == 0
    answer = json.loads(_run(capsys, method, "--step", "1e-3", "--json")[1])
    sliding = method.endswith(("coulomb", "noslip", "tall")) and "elliptic" not in method
    first = 0.0 if "rk4" in method else -5e-4
    assert answer["stop_error_per_speed"] == (first if sliding else None)
    for snippet in answer["snippets"]:
        assert 'timestep="1e-3"' in snippet["mjcf"]
        for line in (*snippet["mjcf"].splitlines(), *snippet["python"].splitlines()):
            assert line in text


@pytest.mark.parametrize("variant", [0, 1])
@pytest.mark.parametrize(
    "method", [METHOD, "mujoco/rk4+coulomb", "mujoco/euler+coulomb+noslip"]
)
def test_what_is_pasted_differs_in_nothing(method, variant, tmp_path, capsys):
    answer = json.loads(_run(capsys, method, "--step", "0.002", "--json")[1])
    model = (
        f"<mujoco>{answer['snippets'][variant]['mjcf']}<worldbody>"
        '<geom name="floor" type="plane" size="1 1 1"/><body pos="0 0 .1"><freejoint/>'
        '<geom name="foot_1" size=".1"/></body></worldbody></mujoco>'
    )
    path = tmp_path / "my.xml"
    path.write_text(model, "utf-8")
    code, found = _check(capsys, path, method)
    assert code == 0
    assert found == {"method": method, "step": 0.002, "differences": [], "warnings": []}
    # a change of any one value is seen
    values = {
        "impratio": "option/impratio",
        "cone": "option/cone",
        "tolerance": "option/tolerance",
        "integrator": "option/integrator",
        "condim": "pair/condim",
        "solimp": "pair/solimp",
        "solref": "pair/solref",
        "solreffriction": "pair/solreffriction",
    }
    other = {"cone": "pyramidal", "integrator": "implicit", "condim": "4", "tolerance": "1e-8"}
    other |= {"impratio": "100", "solimp": "0.9 0.95 0.001", "solref": "0.02 1"}
    other |= {"solreffriction": "-1 -0.3"}
    for name, field in values.items():
        path.write_text(re.sub(rf'{name}="[^"]*"', f'{name}="{other[name]}"', model), "utf-8")
        assert field in [row[0] for row in _check(capsys, path, method)[1]["differences"]]


@pytest.mark.parametrize("name", ["tripod_capsule.xml", "turning.xml", "scene.xml"])
@pytest.mark.parametrize("step", ["2e-5", "1e-4", "1.05e-4", "1e-3"])
def test_contacts_for_another_step_are_warned_of(step, name, tmp_path, capsys):
    for file in CAPSULE.parent.glob("*.xml"):
        text = file.read_text("utf-8").replace('timestep="1e-4"', f'timestep="{step}"')
        (tmp_path / file.name).write_text(text, "utf-8")
    code, found = _check(
        capsys, tmp_path / name, *(["mujoco/rk4+coulomb"] * (name == "turning.xml"))
    )
    warnings = found["warnings"]
    assert code == (0 if step == "1e-4" else 1)
    in_words = _run(
        capsys,
        *(["mujoco/rk4+coulomb"] * (name == "turning.xml")),
        *("--check", str(tmp_path / name)),
    )
    assert in_words[0] == code
    assert in_words[1].count("warning: ") == len(warnings)
    assert any(
        "written for a time step of " in line and " 0.0001 s, and" in line for line in warnings
    ) == bool(code)
    assert any("too stiff" in line for line in warnings) == (step == "1e-3")


def test_too_many_feet_for_the_stiffness_are_warned_of(tmp_path, capsys):
    """Direct contacts on geoms, which have no friction rate, are judged by their stability: at the
    impedance of MuJoCo's default, 0.95, contacts of one body hardly add up."""
    path = tmp_path / "my.xml"
    for stiffness, impedance, expected in (
        (0.4, 1e-4, 1),
        (0.2, 1e-4, 0),
        (1.5, 0.95, 1),
        (1, 0.95, 0),
    ):
        solref = f"{-((stiffness / 1e-3) ** 2)} {-0.6 * stiffness / 1e-3}"
        solref += f'" solimp="{impedance} {impedance} .001'
        feet = "".join(
            f'<geom size=".01" pos="{x} {y} -.04" mass=".01" solref="{solref}"/>'
            for x in (0.1, -0.1)
            for y in (0.1, -0.1)
        )
        path.write_text(
            '<mujoco><option timestep="1e-3"/><worldbody><geom type="plane" size="1 1 1" '
            f'solref="{solref}"/><body pos="0 0 .05"><freejoint/>'
            f'<geom type="box" size=".1 .1 .03" mass="2"/>{feet}</body></worldbody></mujoco>',
            "utf-8",
        )
        code, found = _check(capsys, path)
        assert code == expected
        assert ["too stiff" in line for line in found["warnings"]] == [True] * expected


@pytest.mark.parametrize("step", ["1e-3", "2.5e-5"])
def test_models_are_exported_for_a_step(step, tmp_path, capsys):
    """The same contacts as the adapter gives the model at that step, and at rest at the start."""
    assert main(["models", "export", str(tmp_path), "--step", step]) == 0
    capsys.readouterr()
    folder = tmp_path / "tripod_capsule"
    fields = coulomb_pair(float(step), softening=1.0)
    for name in ("tripod_capsule.xml", "turning.xml"):
        first, text = (folder / name).read_text("utf-8").split("\n", 1)
        assert first == f"<!-- Contacts for a time step of {step} s, and no other. -->"
        assert "1e-4:" not in text
        found = mujoco.MjModel.from_xml_path(str(folder / name))
        assert found.opt.timestep == float(step)
        for field in ("solref", "solreffriction", "solimp"):
            values = getattr(found, f"pair_{field}")
            np.testing.assert_allclose(
                values, np.broadcast_to(fields[field], values.shape), 1e-11
            )
        if found.nkey:
            data = mujoco.MjData(found)
            mujoco.mj_resetDataKeyframe(found, data, 0)
            mujoco.mj_forward(found, data)
            assert abs(data.qacc[2]) < 1e-3 * CHECK["gravity"]
    reduced = mujoco.MjModel.from_xml_path(str(folder / "reduced.xml"))
    assert reduced.opt.timestep == float(step)
    assert reduced.dof_solref[:, 1].min() == pytest.approx(-0.9999 / float(step))
    assert _check(capsys, folder / "scene.xml")[0] == 0
    unchanged = tmp_path / "cone_pendulum" / "cone_pendulum.xml"
    assert unchanged.read_bytes() == systems()["cone-pendulum"].mjcf.read_bytes()
    assert main(["models", "export", str(tmp_path), "--step", "2e-3"]) == 2  # not written over
