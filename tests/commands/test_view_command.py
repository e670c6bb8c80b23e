"""`plumbob view` shows what is measured: the same motion, from each folder's README too."""

import os
import re
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.file_view import view_of_file
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.viewing import AROUND, CAMERA, view_of_scene
from plumbob.engines.audit.scene_reference import model_method
from plumbob.engines.own_motion import Start
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.models.registry import case_of, scene, systems
from plumbob.reports.cli import main

MODELS = Path(__file__).parents[2] / "models"
SHOWN = re.compile(r"^    plumbob view ([\w/-]+)$", re.MULTILINE)
OPENED = "    python -m mujoco.viewer --mjcf=scene.xml\n"
AT_REST = ("capsule-hold", "stack", "pinch")  # systems whose scene is about rest


def scene_view(name):
    """A scene to look at, with its simulation as it is measured and their number of steps."""
    case = case_of(scene(name))
    duration = case.scene.duration
    step = duration / round(duration / REFERENCE_STEP)
    method = model_method(case)
    return (
        view_of_scene(case, method, step),
        compiled(case, method, step),
        round(duration / step),
    )


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("name", systems())
def test_what_is_shown_is_what_is_measured(name):
    """Floor, lights and camera change nothing: coordinates after a third of the motion agree to the
    rounding that 10^3 steps and another order of sums leave, 1e-9 of their size."""
    view, simulation, steps = scene_view(name)
    third = max(steps // 3, 1)
    (data,) = view.states([third])
    built = simulation._begun()
    built.advance(0, third)
    measured = simulation.data
    assert np.allclose(data.qpos, measured.qpos, rtol=1e-9, atol=1e-9)
    assert np.isfinite(data.qvel).all()
    assert not any(warning.number for warning in data.warning)
    assert view.model.ncam >= 1
    assert view.model.nlight >= 1
    moved = np.abs(data.qpos - view_of_start(name)).max()
    assert (moved > 1e-3) == (name not in AT_REST)


def view_of_start(name):
    """The coordinates with which a scene begins."""
    view, _, _ = scene_view(name)
    return np.array(view.data.qpos)


@pytest.mark.parametrize(
    "folder", sorted(path.parent.name for path in MODELS.glob("*/scene.xml"))
)
def test_each_readme_s_lines_show_the_model_from_its_start(folder):
    """The viewer's own line is tried by stepping the file from the key that the text has one
    load."""
    text = (MODELS / folder / "README.md").read_text("utf-8")
    (name,) = SHOWN.findall(text)
    assert systems()[name].mjcf.parent.name == folder
    assert OPENED in text
    assert "*Load key*" in text
    model = mujoco.MjModel.from_xml_path(str(MODELS / folder / "scene.xml"))
    assert [model.key(i).name for i in range(model.nkey)] == ["start"]
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, round(0.5 / model.opt.timestep))
    assert not any(warning.number for warning in data.warning)
    assert mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, CAMERA) >= 0


def test_the_ball_falls_and_the_capsule_drives():
    """The ball of the file alone is thrown up; of the scene it never rises above its start."""
    view, _, steps = scene_view("bouncing-ball")
    heights = [float(data.qpos[0]) for data in view.states(range(0, steps, 20))]
    assert heights[0] == max(heights)
    assert min(heights) < 0.2
    view, _, steps = scene_view("capsule-line")
    marks = [0, steps]
    first, last = (np.array(data.qpos) for data in view.states(marks))
    assert abs(last[7] - first[7]) > 0.05  # [m] the slider along its line
    assert mujoco.mj_name2id(view.model, mujoco.mjtObj.mjOBJ_CAMERA, AROUND + CAMERA) >= 0


FILE = """<mujoco><worldbody><body><joint axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body>
</worldbody><actuator><motor joint="" /></actuator>
<keyframe><key qpos="1"/><key name="up" qpos="3"/></keyframe></mujoco>"""


def test_a_file_begins_at_its_first_keyframe(tmp_path):
    path = tmp_path / "my.xml"
    path.write_text(FILE.replace('<actuator><motor joint="" /></actuator>', ""))
    assert view_of_file(path, Start(), None, 1.0).data.qpos[0] == 1.0
    assert view_of_file(path, Start(keyframe="up"), None, 1.0).data.qpos[0] == 3.0
    path.write_text(
        FILE.replace("<joint ", '<joint name="j" ').replace('joint=""', 'joint="j"')
    )
    controls = np.array([[1.0], [2.0], [3.0]])
    view = view_of_file(path, Start(), controls, 0.02)
    assert view.controls(np.array([0.0, 9.0, 10.0, 29.0, 99.0])).ravel().tolist() == [
        1,
        1,
        2,
        3,
        3,
    ]


REFUSED = {
    "view bouncing-ball --gif old.gif": "gif = 'old.gif': must be a file that does not exist yet",
    "view bouncing-ball --gif ball.png": "gif = 'ball.png': must be",
    "view bouncing-ball --png none/ball.png": "png = 'none/ball.png': must be",
    "view bouncing-ball --at 1": "at = 1.0: must be given with --png",
    "view bouncing-ball --keyframe 0": "keyframe = '0': must be given with a model file",
    "view my.xml --set height=2": "set = ",
    "view nothing --png new.png": "scene = 'nothing': must be",
    "view none.xml --png new.png": "model = 'none.xml': must be a file that exists",
    "view my.xml --png new.png --keyframe 7": "keyframe = '7': must be",
    "view bouncing-ball --png new.png --at -1": "at = -1.0: must be",
    "view bouncing-ball --png new.png --at 1e9": "at = 1000000000.0: must be at most",
}


@pytest.mark.parametrize("line", REFUSED)
def test_wrong_use_is_one_line_and_no_file(line, tmp_path, monkeypatch, capsys):
    pytest.importorskip("PIL")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "plumbob.engines.adapters.mujoco.offscreen.choose_platform", lambda: None
    )
    Path("old.gif").write_text("a picture of the user's")
    Path("my.xml").write_text(FILE.replace('<actuator><motor joint="" /></actuator>', ""))
    assert main(line.split()) == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert REFUSED[line] in said
    assert sorted(os.listdir()) == ["my.xml", "old.gif"]
    assert Path("old.gif").read_text() == "a picture of the user's"


def command(line, folder, **environment):
    """The exit code, stdout and stderr of a command in a process of its own."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if name not in ("MUJOCO_GL", "DISPLAY")
    }
    words = [sys.executable, "-m", "plumbob", *line.split()]
    ran = subprocess.run(
        words, cwd=folder, env={**kept, **environment}, capture_output=True, text=True
    )
    return ran.returncode, ran.stdout, ran.stderr


@pytest.mark.long
def test_pictures_are_written(tmp_path):
    image = pytest.importorskip("PIL.Image")
    code, out, err = command(
        "view bouncing-ball --gif a.gif --png a.png --duration 0.2", tmp_path
    )
    if code == 3:
        pytest.skip(err)
    assert (code, err) == (0, "")
    assert out == "a.png: 0 s\na.gif: 0.2 s in 41 pictures, 0.1 × real speed\n"
    with image.open(tmp_path / "a.gif") as gif, image.open(tmp_path / "a.png") as png:
        assert gif.size == png.size == (480, 360)
        assert gif.n_frames > 20  # pillow joins pictures that are the same
        colours = png.convert("RGB").getcolors(1 << 20)
    assert len(colours) > 100  # the ball, its shade and the floor
    assert sorted(os.listdir(tmp_path)) == ["a.gif", "a.png"]


@pytest.mark.long
def test_what_is_missing_is_one_line(tmp_path, monkeypatch, capsys):
    code, out, err = command("view bouncing-ball --png a.png", tmp_path, MUJOCO_GL="disable")
    assert (code, out) == (3, "")
    assert err == "plumbob: nothing is rendered: the environment has MUJOCO_GL=disable\n"
    code, out, err = command("view bouncing-ball", tmp_path)
    assert (code, out, err.count("\n")) == (3, "", 1)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("plumbob.reports.commands.view._has_pillow", lambda: False)
    assert main(["view", "bouncing-ball", "--png", "a.png"]) == 3
    assert "pip install pillow" in capsys.readouterr().err
    assert os.listdir(tmp_path) == []
