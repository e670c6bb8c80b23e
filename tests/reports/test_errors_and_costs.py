"""The table of engines and systems: numbers of the runs that it names, and what engines lack."""

import math
from dataclasses import replace

import pytest

from plumbob.analytic.schemes import ADAPTIVE, RK4, Scheme
from plumbob.engines.method import Method
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.engines.errors_and_costs import ERRORS_AND_COSTS, numbers
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.reports.view.finding_text import read_findings
from plumbob.tests.support.studies import NS, SCENE, made_up, remeasured

STEPS = (2e-3, 1e-3, 5e-4)


def of(engine, variant="default", **more):
    """A method of an invented engine."""
    return Method(f"{engine}/{variant}", Scheme(RK4), 4, **more)


def study(*curves):
    """A study of one scene: for each method the error at a step."""
    return made_up([(method, STEPS, error) for method, error in curves])


def finding(of_study):
    """The finding that a study's numbers are written as."""
    (one,) = read_findings(ERRORS_AND_COSTS.template, plain(numbers(of_study), FOR_TEMPLATES))
    return one


def cells(of_study):
    """The cells of the table's only row, by engine."""
    (table,) = [table for table in finding(of_study).tables if table.filtered]
    ((_, *row),) = table.rows
    return dict(zip(table.heads[1:], row, strict=True))


def refusing(of_study, name, why, status="unsupported"):
    """The study with all runs of a method refused, or ended, for a reason."""
    return remeasured(
        of_study,
        lambda m: replace(m, status=status, reason=why, errors={}) if m.method == name else m,
    )


def test_a_cell_has_the_error_and_the_cost_at_1_ms_and_the_smallest_error():
    tight = of("first", "tight")
    shown = cells(
        study(
            (of("first"), lambda h: h), (tight, lambda h: h**2), (of("second"), lambda h: 0.2)
        )
    )
    steps = 1.0 / 1e-3
    assert shown["first"].text == f"0.1 %\n{1e-6 * NS * steps:g} ms\n2.5e-7"
    assert shown["first"].hint == "first/default; the smallest error: first/tight at 0.0005"
    assert shown["second"].text == "20 %\n1 ms\n20 %"
    assert (shown["first"].kind, shown["second"].kind) == ("size-d", "size-g")


@pytest.mark.parametrize(
    ("why", "text"),
    [
        ("feature restitution of ground and ball", "no restitution"),
        ("feature hull foot", "no hull foot"),
        ("feature loop rod, which is open at the start", "no loop rod"),
        ("pymunk has no weld: rod has no joint", "no weld"),
        ("contacts have no restitution: a damper makes it", "no restitution"),
        ("a motor's limit is not carried over", "a motor's limit is not carried over"),
    ],
)
def test_a_cell_without_a_run_names_what_the_engine_lacks(why, text):
    both = study((of("first"), lambda h: h), (of("second"), lambda h: h))
    shown = cells(refusing(both, "second/default", why))
    assert (shown["second"].text, shown["second"].hint) == (text, why)


def test_not_asked_diverged_and_not_installed_are_distinct():
    both = study((of("first"), lambda h: h), (of("second"), lambda h: h))
    assert (
        cells(refusing(both, "second/default", "gone", "missing"))["second"].text
        == "not installed"
    )
    assert cells(refusing(both, "second/default", "", "diverged"))["second"].text == "diverges"
    late = study(
        (of("first"), lambda h: h), (of("second"), lambda h: math.inf if h > 7e-4 else h)
    )
    assert cells(late)["second"].text == "diverges\n–\n0.05 %"
    other = find_scene("cone-pendulum/fast-platform")
    asked = replace(both, scenes=(*both.scenes, other))
    elsewhere = replace(both.convergence[1], scene=other.name)
    asked = replace(asked, convergence=(both.convergence[0], elsewhere))
    assert cells(asked)["second"].text == "not run"


def test_a_declared_limit_names_what_an_engine_lacks_that_was_not_asked():
    both = made_up([(of(name), STEPS, lambda h: h) for name in ("mujoco", "pymunk")])
    body = find_scene("free-body/flip")
    first, second = both.convergence
    changed = replace(
        both, scenes=(body, *both.scenes), convergence=(replace(first, scene=body.name), second)
    )
    rows = numbers(changed).rows
    (row,) = [row for row in rows if row.scene == body.name]
    assert row.cells[1].why == "pymunk has two dimensions, and the body turns in three"


def test_a_solver_that_chooses_its_steps_is_shown_at_its_tightest_tolerance():
    solver = Method("second/solver", Scheme(ADAPTIVE), None, "tolerance", {}, (1e-6, 1e-9))
    both = made_up(
        [(of("first"), STEPS, lambda h: h), (solver, (1e-6, 1e-9), lambda tolerance: tolerance)]
    )
    text = cells(both)["second"].text
    assert text.splitlines()[0] == "1.0e-9 at rtol 1e-9"


def test_engines_of_a_picture_are_named_where_their_runs_are():
    both = study((of("first"), lambda h: h), (of("second"), lambda h: 3.0 * h))
    (figure,) = finding(both).figures
    (trace,) = figure.traces
    assert figure.title == SCENE
    assert trace["text"] == ["first", "second"]
    assert trace["y"] == [1e-3, 3e-3]


def test_the_default_method_is_shown_whatever_the_order_of_the_runs():
    both = study(
        (of("first"), lambda h: h),
        (of("first", "b"), lambda h: h**2),
        (of("second"), lambda h: h),
    )
    turned = replace(both, convergence=both.convergence[::-1])
    assert cells(turned) == cells(both)


def test_one_engine_alone_has_no_table():
    assert numbers(study((of("first"), lambda h: h), (of("first", "b"), lambda h: h))) is None
