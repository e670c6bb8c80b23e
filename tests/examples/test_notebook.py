"""The example notebook runs from top to bottom, and what its cells show can be shown."""

import ast
import json
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).with_name("audit.ipynb")


def shown(cells):
    """What the last line of each cell of code gives, where it is an expression."""
    names = {}
    values = []
    for cell in cells:
        if cell["cell_type"] == "code":
            body = ast.parse("".join(cell["source"])).body
            last = body.pop() if isinstance(body[-1], ast.Expr) else None
            exec(compile(ast.Module(body, []), str(NOTEBOOK), "exec"), names)
            if isinstance(last, ast.Expr):
                expression = compile(ast.Expression(last.value), str(NOTEBOOK), "eval")
                values.append(eval(expression, names))
    return values


@pytest.mark.long
def test_the_notebook_runs(capsys):
    notebook = json.loads(NOTEBOOK.read_text("utf-8"))
    # they are made where it runs
    assert not any(cell.get("outputs") for cell in notebook["cells"])
    rich = [value for value in shown(notebook["cells"]) if value is not None]
    cards = [value._repr_html_() for value in rich]
    assert len(cards) == 3  # two audits and a plot
    printed = capsys.readouterr().out
    for words in ("euler at 0.01 s", "rk4 0.01 s", "headings", "<pair"):
        assert words in printed
