"""Stored results as columns: all numbers of a page, CSV without formulas, a documented schema."""

import csv
import io
import json
import math
import re
import sys
from itertools import chain
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.box import Side, box
from plumbob.engines.registry import method
from plumbob.engines.sweep import store as sweep_store
from plumbob.engines.sweep.sweep import sweep, sweep_of
from plumbob.reports.cli import main
from plumbob.reports.columns.audit_columns import audit_columns, audited_step_columns
from plumbob.reports.columns.columns import FORMULA_STARTS, columns_of, table_schemas
from plumbob.reports.columns.study_columns import StudyColumns
from plumbob.reports.columns.sweep_columns import point_columns
from plumbob.reports.records.page_records import records_of
from plumbob.reports.view.method_results import results_of
from plumbob.reports.view.site.views import scene_view
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import SCENE, quick

STUDY_TABLES = (
    *("pairs", "runs", "errors", "budgets", "parameters", "recommendations", "trims"),
    "derivatives",
)
NUMBER = re.compile(r"(?<![\w.+^])-?\d+(?:\.\d+)?(?:e-?\d+)?(?: ?(?:ms|µs|ns|s|%|×)(?!\w))?")
SCALES = {"ms": 1e-3, "µs": 1e-6, "ns": 1e-9, "%": 1e-2}


def known_values(data, scene, name):
    """Sizes of all numbers in the rows of a scene, and of a method if one is named."""
    values = []
    for table in (getattr(data, table) for table in STUDY_TABLES):
        rows = table.where(scene=scene)
        if name and "method" in rows.arrays:
            rows = rows.where(method=name)
        numbers = [column for column in rows.arrays.values() if column.dtype.kind in "fi"]
        for texts in (rows.arrays[n] for n in ("reason", "text") if n in rows.arrays):
            values += [size for text in texts for size, _ in shown_numbers(str(text))]
        values += list(chain.from_iterable(np.abs(column).tolist() for column in numbers))
        # Computing time and simulated time are shown as either ratio.
        for ratio in ("real_time_factor", "ns_per_second"):
            if ratio in rows.arrays:
                values += (1.0 / rows[ratio]).tolist() + (1e9 / rows[ratio]).tolist()
                values += (1e-9 * rows[ratio]).tolist()
    values += costs_of_runs(data, scene, name)
    return np.array(values, dtype=float)


def costs_of_runs(data, scene, name):
    """The computing time of a simulated second [ms], and the simulated time over it, of each run of
    a method, by the cost of a step of the pair."""
    pairs = data.pairs.where(scene=scene, method=name)
    runs = data.runs.where(scene=scene, method=name)
    costs = []
    trims = data.trims.where(scene=scene, method=name)
    step_costs = [pairs[column].tolist() for column in ("ns_per_step", "ns_low", "ns_high")]
    step_costs += [
        trims[column].tolist() for column in ("ns_default", "ns_flags", "ns_trimmed")
    ]
    for step_cost in chain.from_iterable(step_costs):
        of_run = 1e3 * step_cost / (runs["real_time_factor"] * runs["ns_per_step"])
        costs += of_run.tolist() + (1e3 / of_run).tolist()
    return costs


def shown_numbers(text):
    """The sizes of the numbers in a text of a page, each with half a unit of its last digit."""
    for match in NUMBER.findall(text):
        digits, unit = re.fullmatch(r"([-\d.e]+)(.*)", match).groups()
        mantissa, _, exponent = digits.partition("e")
        decimals = len(mantissa.partition(".")[2])
        scale = SCALES.get(unit.strip(), 1.0) * 10.0 ** int(exponent or 0)
        half = 0.51 * 10.0**-decimals
        if unit.strip() == "×":  # multiples have two significant digits
            half = max(
                half, 0.051 * 10.0 ** math.floor(math.log10(abs(float(mantissa)) or 1.0))
            )
        yield abs(float(mantissa)) * scale, half * scale


def missing_numbers(data, study):
    """The cells of the scene's page whose numbers are in no table, with the numbers of each."""
    records = records_of(study)
    results = [r for (name, _), r in results_of(study, records).items() if name == SCENE]
    record = records.scenes[SCENE]
    view = scene_view(study, record, record.exact, results)
    methods = {result.name for result in results}
    lacking = []
    count = 0
    for table in (view.first, *view.rest):
        name = ""
        for row in table.rows:
            first = row[0].text
            name = first if first in methods else name if not first else ""
            values = known_values(data, SCENE, name)
            texts = [cell.text for cell in row[bool(name) :] if cell.kind != "reason"]
            for text in texts:
                for size, half in shown_numbers(text.replace(SCENE, "")):
                    count += 1
                    if size and not (np.abs(values - size) <= half).any():
                        lacking.append((table.caption, name, text, size))
    return lacking, count


@pytest.mark.long
def test_every_number_of_a_page_is_in_a_table(monkeypatch):
    study = quick()
    data = StudyColumns(study)
    lacking, count = missing_numbers(data, study)
    assert count > 50
    assert not lacking
    table = data.errors
    nudged = table["error"] * 1.01  # by more than the half of a third digit
    changed = SimpleNamespace(**{name: getattr(data, name) for name in STUDY_TABLES})
    arrays = {**table.arrays, "error": nudged, "tolerance": 2.0 * table["tolerance"]}
    changed.errors = type(table)(table.name, arrays, table.meanings)
    assert missing_numbers(changed, study)[0]


def test_a_data_frame_in_three_lines(tmp_path, monkeypatch):
    """A stand-in takes the place of pandas; without it, the error is one sentence."""
    save(quick(), tmp_path / "studies.sqlite3")
    monkeypatch.setitem(sys.modules, "pandas", None)
    errors = plumbob.load(tmp_path).errors
    with pytest.raises(ImportError, match="pandas is not installed: `pip install pandas`"):
        errors.to_pandas()
    frame = SimpleNamespace(attrs={})
    pandas = SimpleNamespace(DataFrame=lambda columns: vars(frame).update(columns) or frame)
    monkeypatch.setitem(sys.modules, "pandas", pandas)
    assert errors.to_pandas().error is errors["error"]
    assert frame.attrs["units"]["error_at_end"] == "unit"
    measured = quick().convergence[0].measurements[0]
    rows = errors.where(scene=measured.scene, method=measured.method, step=measured.step)
    sizes = {
        str(name): size for name, size in zip(rows["observable"], rows["error"], strict=True)
    }
    assert sizes == {name: error.largest for name, error in measured.errors.items()}


@pytest.mark.parametrize("start", FORMULA_STARTS)
def test_no_text_of_csv_is_a_formula(start, tmp_path):
    hostile = f'{start}cmd|"/C calc"!A1\n,second\0'
    table = columns_of("changes", [{"scene": hostile, "growth": -0.25, "what": '=1+1", x'}])
    text = table.to_csv(tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_bytes() == text.encode()
    heads, row = csv.reader(io.StringIO(text, newline=""))
    cells = dict(zip(heads, row, strict=True))
    assert not any(cell.startswith(FORMULA_STARTS) for cell in row if cell != "-0.25")
    assert cells["scene"].removeprefix("'").startswith(start if start not in "\r" else " ")
    assert (cells["what"], float(cells["growth"])) == ("'=1+1\", x", -0.25)
    with pytest.raises(ParameterError, match="a new file in a folder that can be written to"):
        table.to_csv(tmp_path / "out.csv")


def test_csv_has_every_bit_and_says_what_is_not_known():
    numbers = [0.1 + 0.2, 1e-300, math.inf, math.nan, -0.0]
    table = columns_of("errors", [{"error": x, "steps": None, "drawn": x > 0} for x in numbers])
    rows = list(csv.DictReader(io.StringIO(table.to_csv())))
    read = [float(row["error"]) if row["error"] else math.nan for row in rows]
    assert np.array_equal(read, numbers, equal_nan=True)
    assert [row["steps"] for row in rows] == [""] * 5
    assert [row["drawn"] for row in rows] == ["true", "true", "true", "false", "false"]
    assert len(columns_of("errors", [])) == 0


def test_latex_is_escaped_and_short():
    rows = [{"scene": "a_b & 50%", "what": r"\x{}", "growth": 1.23456e-7, "old": "~^"}]
    text = columns_of("changes", rows).to_latex()
    assert (
        r"a\_b \& 50\% &  & \textbackslash{}x\{\} & \textasciitilde{}\textasciicircum{}" in text
    )
    assert r"$1.23 \cdot 10^{-7}$ \\" in text
    assert text.startswith("\\begin{tabular}{lllllr}\n")
    assert text.endswith("\\end{tabular}\n")


def test_the_schema_names_every_column(capsys):
    """The parameters of scenes, which become columns of a sweep, are none of its columns."""
    assert main(["list", "columns"]) == 0
    listed = {line.split("  ")[0] for line in capsys.readouterr().out.splitlines()}
    data = StudyColumns(quick())
    for name, schema in table_schemas().items():
        assert {name, *(f"{name}.{column}" for column in schema["columns"])} <= listed
        assert set(schema["paper"]) <= set(schema["columns"])
        assert {kind for kind, _, _ in schema["columns"].values()} <= {
            *("text", "number", "integer", "truth")
        }
        rows = getattr(data, name, None)
        if rows is not None and len(rows):
            assert list(rows.arrays) == list(schema["columns"])
    with pytest.raises(ParameterError, match="column = 'eror': must be one of scene, method"):
        data.errors["eror"]


def test_sweeps_are_loaded_with_their_parameters(tmp_path):
    around = box("linear-pendulum", {"gravity": 3.0}, [Side("theta", 0.1, 0.2)])
    asked = sweep_of(around, (3,), [method("ode/rk4")], [1e-2])
    with sweep_store.keeping(tmp_path / sweep_store.FILE, asked) as (_, keep):
        swept = sweep(asked, {}, keep)
    (points,) = plumbob.load(tmp_path).sweeps
    assert points["theta"] == pytest.approx([0.1, 0.15, 0.2])
    assert np.array_equal(points["error"], swept.errors.ravel())
    assert points["status"].tolist() == ["done"] * 3
    assert points.to_csv() == point_columns(swept).to_csv()
    assert "theta" not in table_schemas()["points"]["columns"]
    with pytest.raises(ParameterError, match="where `plumbob validate` has stored a study"):
        _ = plumbob.load(tmp_path).runs


AUDIT = {
    "model": "=evil.xml",
    "path": "robots/=evil.xml",
    "integrator": "euler",
    "step": 0.002,
    "certified_until": 1.0,
    "error": None,
    "order": {"slope": 1.01, "low": 1.0, "high": 1.02},
    "stability": [{"largest_step": 0.004}],
    "versions": {"mujoco": "3.17.0"},
    "steps": [
        {"integrator": "rk4", "step": 1e-3, "error": 1e-6, "ns_per_second": 1e6, "why": ""}
    ],
    "returns": [{"integrator": "rk4", "step": 1e-3, "mean": 4.5, "difference": None}],
}


def test_audits_are_columns(tmp_path):
    table = audit_columns([AUDIT, {"model": "bad.xml", "path": "bad.xml", "why": "no joints"}])
    assert table["error"].tolist()[0] == math.inf  # JSON has no infinity: the run diverged
    assert math.isnan(table["error"][1])
    assert table["largest_step"][0] == 0.004
    assert table["order"][0] == 1.01
    assert "'=evil.xml" in table.to_csv()
    (tmp_path / "audit-evil.json").write_text(json.dumps(AUDIT))
    data = plumbob.load(tmp_path)
    assert data.audits["model"].tolist() == ["=evil.xml"]
    assert data.audited_steps["error"].tolist() == [1e-6]
    assert data.returns["mean"].tolist() == [4.5]
    assert math.isnan(data.returns["difference"][0])
    assert audited_step_columns([AUDIT]).to_csv() == data.audited_steps.to_csv()


@pytest.mark.parametrize("text", ["", "[", "[1]", '{"a": 1}', '{"model": 1, "steps": 3}'])
def test_a_file_that_is_no_audit_is_refused(text, tmp_path):
    file = tmp_path / "audit-x.json"
    file.write_text(text)
    with pytest.raises(
        ParameterError, match="must be a file that `plumbob audit --json` printed"
    ):
        _ = plumbob.load(file).audits


@pytest.mark.parametrize(
    "line",
    [
        ["run", "linear-pendulum/overdamped", "ode/rk4", "--step", "0.01"],
        ["compare", "out", "out"],
    ],
)
def test_commands_print_tables(line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    save(quick(), tmp_path / "out" / "studies.sqlite3")
    name = {"run": "errors", "compare": "changes"}[line[0]]
    assert main([*line, "--csv"]) == 0
    heads, *rows = csv.reader(io.StringIO(capsys.readouterr().out))
    assert heads == list(table_schemas()[name]["columns"])
    assert bool(rows) == (name == "errors")
    assert main([*line, "--latex"]) == 0
    assert capsys.readouterr().out.startswith(r"\begin{tabular}")
    assert main([*line, "--csv", "--json"]) == 2
    assert "csv = True: must be left out with --json" in capsys.readouterr().err


def test_bibtex_is_that_of_the_citation_file(capsys):
    """The citation file is read by its lines: no reader of YAML is needed for them."""
    assert main(["cite", "--bibtex"]) == 0
    text = capsys.readouterr().out
    lines = Path(plumbob.__path__[0], "CITATION.cff").read_text("utf-8").splitlines()
    fields = [line.strip().removeprefix("- ").partition(": ") for line in lines]
    values = [
        value.strip('"') for key, _, value in fields if key in ("title", "version", "doi")
    ]
    assert len(values) >= 5
    assert all(value in text for value in values)
    assert len(set(re.findall(r"^@\w+\{(.+),$", text, re.M))) == text.count("\n@") + 1


LINES = {
    "sweep linear-pendulum ode/rk4 --vary theta=0.1:0.2:2 --step 0.01 --jobs 1": (0, "points"),
    "audit still.xml none.xml": (2, "audits"),
    "validate --scenes linear-pendulum/overdamped --methods ode/rk4 --jobs 1": (0, "errors"),
}


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("line", LINES)
def test_other_commands_print_csv(line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("still.xml").write_text("<mujoco/>")
    expected, name = LINES[line]
    assert main([*line.split(), "--csv"]) == expected
    heads, *rows = csv.reader(io.StringIO(capsys.readouterr().out))
    columns = list(table_schemas()[name]["columns"])
    assert heads == columns + ["theta"] * (name == "points")
    assert len(rows) >= 2
    if name == "audits":
        assert {row[heads.index("path")] for row in rows} == {"still.xml", "none.xml"}
        assert all(row[heads.index("why")] for row in rows)
