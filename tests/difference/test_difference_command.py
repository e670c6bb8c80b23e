"""`plumbob difference`: verdicts, exit codes, formats, a page; hostile recordings are one line."""

import copy
import io
import json
import resource
import zipfile

import mujoco
import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.reports.cli import main
from plumbob.tests.difference.planted_changes import LEGS, ROW, Motion, pushed, without

STEPS = 70


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A folder with a model and recordings of it, and the model."""
    there = tmp_path_factory.mktemp("recorded")
    model = mujoco.MjModel.from_xml_string(LEGS["euler"])
    (there / "leg.xml").write_text(LEGS["euler"])
    arrays = Motion(model, STEPS).arrays()
    np.savez(there / "a.npz", **arrays)
    dense = copy.copy(model)
    dense.opt.jacobian = 1
    np.savez(there / "sparse.npz", **Motion(dense, STEPS).arrays())
    off = Motion(model, STEPS, at=ROW, other=without(model.geom("heel").id))
    np.savez(there / "off.npz", **off.arrays())
    np.savez(there / "single.npz", **Motion(model, STEPS, precision="f4").arrays())
    (there / "a.json").write_text(json.dumps({k: v.tolist() for k, v in arrays.items()}))
    parts = [np.reshape(arrays[part], (STEPS + 1, -1)) for part in arrays]
    names = [
        f"{part}_{k}"
        for part, rows in zip(arrays, parts, strict=True)
        for k in range(rows.shape[1])
    ]
    head = ",".join(["time", *names[1:]])
    np.savetxt(there / "a.csv", np.hstack(parts), delimiter=",", header=head, comments="")
    np.savetxt(there / "bare.csv", np.hstack(parts), delimiter=",", fmt="%.9g")
    return there, model


def run(there, *words):
    files = [str(there / word) if "." in word else word for word in words]
    return main(["difference", *files, "--model", str(there / "leg.xml")])


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["a.npz"], 0, "all steps are the model's"),
        (["a.npz", "a.json"], 0, "the same bits"),
        (["a.npz", "a.csv"], 0, "the same bits"),
        (["a.npz", "sparse.npz"], 0, "explained by rounding"),
        (["bare.csv"], 0, "9 significant digits"),
        (["single.npz"], 0, "single precision"),
        (["single.npz", "--precision", "float64"], 1, "is not this model's"),
        (["a.npz", "off.npz"], 1, "is missing"),
    ],
)
def test_verdicts_have_exit_codes(recorded, capsys, words, code, says):
    there, _ = recorded
    assert run(there, *words) == code
    assert says in capsys.readouterr().out


def test_json_names_the_step_and_the_page_is_written(recorded, capsys, tmp_path):
    there, _ = recorded
    assert run(there, "a.npz", "off.npz", "--json", "--out", str(tmp_path / "out")) == 1
    answer = json.loads(capsys.readouterr().out)
    (finding,) = answer["recordings"][1]["findings"]
    assert (finding["row"], finding["cause"]) == (ROW, "contact")
    assert "heel" in finding["part"]
    assert answer["difference"]["first"]["time"] == pytest.approx(finding["end"])
    assert "Is this difference a bug?" in (tmp_path / "out" / "difference.html").read_text(
        "utf-8"
    )
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "difference.html").write_text("other")
    assert run(there, "a.npz", "--out", str(tmp_path / "own")) == 2


def test_an_assertion_says_the_step_and_the_term(recorded, plumbob_same_motion):
    there, model = recorded
    plumbob_same_motion(there / "a.npz", there / "sparse.npz", model)
    with pytest.raises(AssertionError, match=r"step from 0.12 s to 0.122 s.*heel is missing"):
        plumbob_same_motion(there / "a.npz", there / "off.npz", model)
    moved = Motion(model, STEPS, at=ROW, other=pushed(4, 1e-3)).arrays()
    result = plumbob.difference(moved, model=model)
    assert (result.verdict, result.steps[0].findings[0].place) == ("other steps", "joint knee")
    assert result.to_dict()["recordings"][0]["findings"][0]["unit"] == "rad/s²"
    with pytest.raises(ParameterError, match="precision"):
        plumbob.difference(moved, model=model, precision="half")


@pytest.mark.long
def test_a_double_and_a_single_motion_are_the_same_in_single_precision(recorded):
    there, model = recorded
    files = there / "a.npz", there / "single.npz"
    plumbob.assert_same_motion(*files, model, precision="float32")
    with pytest.raises(AssertionError, match="is not this model's"):
        plumbob.assert_same_motion(*files, model, precision="float64")


def changed(arrays, **parts):
    return {name: value for name, value in (arrays | parts).items() if value is not None}


def not_finite(values):
    values = values.copy()
    values[5] = np.nan
    return values


HOSTILE = {
    "no time": lambda a: changed(a, time=None),
    "no velocities": lambda a: changed(a, qvel=None),
    "no controls": lambda a: changed(a, ctrl=None),
    "times that go back": lambda a: changed(a, time=a["time"][::-1]),
    "equal times": lambda a: changed(a, time=0.0 * a["time"]),
    "NaN": lambda a: changed(a, qpos=not_finite(a["qpos"])),
    "infinite": lambda a: changed(a, ctrl=a["ctrl"] + np.inf),
    "another model": lambda a: changed(a, qpos=a["qpos"][:, 1:]),
    "ragged": lambda a: changed(a, qvel=a["qvel"][:-3]),
    "text": lambda a: changed(a, qvel=a["qvel"].astype(str)),
    "complex": lambda a: changed(a, qvel=a["qvel"].astype(complex)),
    "objects": lambda a: changed(a, qvel=a["qvel"].astype(object)),
    "one sample": lambda a: {name: value[:1] for name, value in a.items()},
    "nothing": lambda a: {name: value[:0] for name, value in a.items()},
    "no quaternion": lambda a: changed(a, qpos=0.5 * a["qpos"]),
    "large numbers": lambda a: changed(a, qvel=1e300 * (1 + a["qvel"])),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_arrays_are_one_line(recorded, capsys, tmp_path, case):
    there, model = recorded
    arrays = HOSTILE[case](Motion(model, 20).arrays())
    np.savez(tmp_path / "bad.npz", allow_pickle=True, **arrays)
    code = run(there, str(tmp_path / "bad.npz"))
    output = capsys.readouterr()
    if case == "large numbers":
        assert code == 1
        return
    assert code == 2
    assert output.err.count("\n") == 1
    assert "bad.npz" in output.err
    with pytest.raises(ParameterError):
        plumbob.difference(arrays, model=model)


def unpacking_to(size):
    """A .npz file whose array of zeros has so many bytes when unpacked."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        head, {"descr": "<f8", "fortran_order": False, "shape": (size // 8,)}
    )
    packed = io.BytesIO()
    with (
        zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file,
        file.open("time.npy", "w", force_zip64=True) as array,
    ):
        array.write(head.getvalue())
        for _ in range(size // 2**20):
            array.write(bytes(2**20))
    return packed.getvalue()


TEXTS = {
    "ragged.csv": b"time,qpos_0\n1,2\n3\n",
    "words.csv": b"time,qpos_0\na,b\n",
    "twice.csv": b"time,time\n1,2\n3,4\n",
    "few.csv": b"1,2\n3,4\n",
    "empty.csv": b"",
    "bytes.csv": bytes(range(256)),
    "list.json": b"[1, 2]",
    "broken.json": b'{"time": [',
    "deep.json": b"[" * 100_000,
    "ragged.json": b'{"time": [0, 1], "qpos": [[1], [1, 2]], "qvel": [[1], [2]]}',
    "no.npz": b"not a zip file",
    "a.txt": b"1",
}


@pytest.mark.parametrize("name", TEXTS)
def test_hostile_files_are_one_line(recorded, capsys, tmp_path, name):
    there, _ = recorded
    (tmp_path / name).write_bytes(TEXTS[name])
    assert run(there, "a.npz", str(tmp_path / name)) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.long
def test_a_file_of_a_gigabyte_is_refused_in_bounded_memory(recorded, capsys, tmp_path):
    there, _ = recorded
    with (tmp_path / "sparse.csv").open("wb") as file:
        file.truncate(2**30)
    (tmp_path / "bomb.npz").write_bytes(unpacking_to(2**28))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for name in ("sparse.csv", "bomb.npz"):
        assert run(there, str(tmp_path / name)) == 2
        assert "bytes" in capsys.readouterr().err
    # [KiB] LARGEST_RECORDING, and its copy while it is unpacked
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2.5 * 200_000


def test_motions_without_times_in_common_are_refused(recorded):
    _, model = recorded
    arrays = Motion(model, 20).arrays()
    late = changed(arrays, time=arrays["time"] + 1000.0)
    with pytest.raises(ParameterError, match="times in common"):
        plumbob.difference(arrays, late, model)
