"""The table in engines/README.md has the form that its command writes, and errors that are so."""

import re
from dataclasses import replace

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study import store
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.results import Analysed
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.engines.errors_and_costs import ERRORS_AND_COSTS, numbers
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.tests.support.studies import SCENE, made_up
from plumbob.tests.validation import engines_table
from plumbob.tests.validation.engines_table import BEGIN, END, README, filled, main

TEXT = README.read_text("utf-8")
MOST_LINES = 250
SIZE = r"(?:[\d.]+ %|[\d.]+e-\d+|[\d.]+×|0|–)"
NUMBERS = re.compile(
    rf"(?:{SIZE}(?: at (?:rtol )?[\d.e-]+(?: s)?)?|diverges); (?:[\d.]+ ms|–); {SIZE}"
)
# of the error in a cell: two digits, and 2 % between versions
WITHIN = 0.07
QUICK = ("cone-pendulum", "linear-pendulum", "projectile")  # whose exact motions take no time


def rows(text=TEXT):
    """The lines of the table, as lists of their cells, the heads first."""
    lines = text.partition(BEGIN)[2].partition(END)[0].splitlines()
    table = [line for line in lines if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


def malformed(table):
    """What a table, of rows as above, has beside the form that is written."""
    heads, rule, *body = table
    wrong = [] if heads == ["scene", *engines_table.ours()] else [heads]
    wrong += [] if set(rule) == {"---"} else [rule]
    if sorted(row[0].partition("/")[0] for row in body) != engines_table.system_names():
        wrong.append("systems")
    for row in body:
        find_scene(row[0])
        cells = [c for c in row[1:] if not NUMBERS.fullmatch(c)]
        wrong += [c for c in cells if not c or ";" in c or re.search(r"\d", c)]
        wrong += [row] if len(row) != len(heads) else []
    return wrong


def invented():
    """A study of two engines on one scene, with its finding."""
    curves = [(find_method(m), (2e-3, 1e-3), lambda h: h) for m in ("mujoco/euler", "ode/rk4")]
    study = made_up(curves)
    kept = Analysed(
        ERRORS_AND_COSTS.template,
        "finding",
        "engines",
        "",
        plain(numbers(study), FOR_TEMPLATES),
    )
    provenance = Provenance(
        {"mujoco": "3.17.0", "heyoka": "not installed"}, {"processor": "one"}
    )
    return replace(study, analyses=(kept,), provenance=provenance)


def test_the_table_has_the_form_that_is_written_and_the_readme_is_short():
    assert malformed(rows()) == []
    assert len(TEXT.splitlines()) <= MOST_LINES
    table = rows()
    cell = table[1 + len(table) // 2][1:]
    place = next(i for i, text in enumerate(cell) if NUMBERS.fullmatch(text))
    for wrong in ("1.3 %, 2 ms, 1 %", "1.3 %; 2 ms", "", "0.013; 2 ms; 1 %"):
        changed = [list(row) for row in table]
        changed[1 + len(table) // 2][1 + place] = wrong
        assert malformed(changed) != [], wrong
    assert malformed(table[:-1]) == ["systems"]


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, id=row[0], marks=[] if row[0].startswith(QUICK) else pytest.mark.long)
        for row in rows()[2:]
    ],
)
def test_errors_of_mujoco_are_those_of_the_table(row):
    """Costs are of one machine, and smallest errors of a whole study: they are not held here."""
    text = row[rows()[0].index("mujoco")].partition(";")[0].partition(" at ")[0]
    scene = find_scene(row[0])
    case = case_of(scene)
    found, _ = measure(case, find_method("mujoco/euler"), 1e-3, theory=False)
    error = relative_error(found, case.system.quantities(case))
    unit = {"%": 1e-2, "×": 1.0}.get(text[-1], 1.0)
    stated = unit * float(text.rstrip(" %×"))
    assert error == pytest.approx(stated, rel=WITHIN)
    assert error * 1.2 != pytest.approx(stated, rel=WITHIN)


def test_the_command_replaces_the_table_and_nothing_else(tmp_path, monkeypatch, capsys):
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{BEGIN}\n| old |\n{END}after\n", "utf-8")
    monkeypatch.setattr(engines_table, "README", readme)
    monkeypatch.setattr(engines_table, "ours", lambda: ["mujoco", "ode"])
    monkeypatch.setattr(engines_table, "system_names", lambda: ["cone-pendulum"])
    monkeypatch.setattr(store, "load", lambda file: invented())
    for _ in range(2):  # the second time it replaces what it wrote
        assert main([str(tmp_path)]) == 0
        assert readme.read_text("utf-8") == (
            f"before\n{BEGIN}\n| scene | mujoco | ode |\n| --- | --- | --- |\n"
            f"| {SCENE} | 0.1 %; 1 ms; 0.1 % | 0.1 %; 1 ms; 0.1 % |\n\n"
            f"Measured with mujoco 3.17.0, on one.\n\n{END}after\n"
        )
    assert capsys.readouterr().out.startswith("written: ")


def test_a_study_that_lacks_engines_or_systems_changes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(store, "load", lambda file: invented())
    assert main([str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert "without dart, drake" in said
    assert "n-pendulum" in said
    assert README.read_text("utf-8") == TEXT


@pytest.mark.parametrize("content", [None, b"no store"])
def test_a_folder_without_a_study_is_refused_in_one_line(tmp_path, capsys, content):
    if content is not None:
        (tmp_path / store.FILE).write_bytes(content)
    assert main([str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("plumbob: ")


@pytest.mark.parametrize("text", ["", BEGIN, END + BEGIN, 2 * (BEGIN + END)])
def test_a_readme_without_the_two_marks_once_is_refused(text):
    with pytest.raises(engines_table.ParameterError, match="marks"):
        filled(text, "table")
