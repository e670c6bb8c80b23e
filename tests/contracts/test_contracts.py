"""The contracts hold for this tree, and each is red on a tree that breaks it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from plumbob.tests.contracts import file_contracts, import_contracts, wording

ROOT = Path(__file__).parents[2]
Contract = Callable[[Path], list[str]]

GOOD = {
    "__init__.py": '"""The package of the tree."""\n',
    "analytic/__init__.py": "",
    "analytic/cone.py": '"""What a cone weighs."""\nimport numpy\nNAMES = ("a", "b")\n',
    "models/__init__.py": "",
    "models/cone/__init__.py": '"""A cone on a pin."""\nfrom plumbob.analytic.cone import NAMES\n',
    "models/cone/README.md": "# Cone\n\n## Provenance\n\nhttps://example.org/home/cone\n",
    "models/cone/cone.xml": "<mujoco/>",
    "models/cone/scene.xml": "<mujoco/>",
    "models/cone/cone.png": "",
    "engines/__init__.py": "",
    "engines/adapters/mujoco.py": '"""Scenes in MuJoCo\'s terms."""\nimport mujoco\n',
    "reports/__init__.py": "",
    "reports/view/page.py": '"""The page, all of it."""\nimport plumbob.models.cone, plotly\n',
    "reports/cli.py": '"""Commands of it."""\ndef main():\n    import plumbob.reports.view.page\n',
}
STATE = '"""Keeps a register."""\n'
SIXTEEN = "".join(f"    x{number} = 0\n" for number in range(16))


def functions(count: int, body: str) -> str:
    """A file of so many functions with this body."""
    return "".join(f"def f{number}():\n{body}" for number in range(count))


# contract, and the smallest changes to a good tree that break it
BROKEN: tuple[tuple[Contract, Mapping[str, str]], ...] = (
    (import_contracts.wrong_way, {"analytic/cone.py": "import plumbob.models.cone\n"}),
    (
        import_contracts.wrong_way,
        {"models/cone/__init__.py": "from plumbob.engines import method\n"},
    ),
    (
        import_contracts.wrong_way,
        {"engines/late.py": "def f():\n    from plumbob.reports.view.page import x\n"},
    ),
    (import_contracts.wrong_way, {"models/cone/up.py": "from ...engines import method\n"}),
    (import_contracts.wrong_way, {"reports/spy.py": "import plumbob.tests.contracts.tree\n"}),
    (import_contracts.foreign_libraries, {"analytic/cone.py": "import pandas\n"}),
    (import_contracts.foreign_libraries, {"analytic/cone.py": "def f():\n    import mujoco\n"}),
    (
        import_contracts.circles,
        {
            "models/a.py": "from plumbob.models.b import x\n",
            "models/b.py": "def f():\n    from . import a\n",
        },
    ),
    (
        import_contracts.folder_circles,
        {
            "reports/view/traces.py": "from plumbob.reports.judge import verdict\n",
            "reports/judge/verdict.py": "def f():\n    from plumbob.reports.view import page\n",
        },
    ),
    (
        import_contracts.theory_upside_down,
        {"analytic/systems/cone.py": "from plumbob.analytic.errors import sliding_motion\n"},
    ),
    (
        import_contracts.theory_upside_down,
        {"analytic/numerics/roots.py": "def f():\n    from plumbob.analytic.systems import cone\n"},
    ),
    (
        import_contracts.adapter_internals,
        {"reports/cli.py": "from plumbob.engines.adapters.mujoco import ENGINE\n"},
    ),
    (
        import_contracts.adapter_internals,
        {
            "engines/adapters/ode/__init__.py": "",
            "engines/adapters/heyoka.py": "from .ode.equation import Equation\n",
        },
    ),
    (
        import_contracts.engines_on_the_page,
        {"reports/view/page.py": "engine_of(method).prepare(case, method, 1e-3).run()\n"},
    ),
    (
        import_contracts.engines_on_the_page,
        {"reports/analyses/cone.py": "from x import measure\nmeasure()\n"},
    ),
    (
        import_contracts.motions_on_the_page,
        {"reports/view/page.py": "def f():\n    from plumbob.analytic.systems import cone\n"},
    ),
    (
        import_contracts.motions_on_the_page,
        {"reports/view/page.py": "from plumbob.models.registry import systems\n"},
    ),
    (
        import_contracts.motions_on_the_page,
        {
            "reports/view/page.py": "import plumbob.models.cone\n",
            "models/cone/__init__.py": "from scipy import special\n",
        },
    ),
    (import_contracts.heavy_imports, {"engines/method.py": "import mujoco\n"}),
    (import_contracts.heavy_imports, {"engines/adapters/mujoco.py": "from pymunk import Body\n"}),
    (
        import_contracts.heavy_imports,
        {"reports/cli.py": "try:\n    import plotly.io\nfinally:\n    0\n"},
    ),
    (import_contracts.heavy_imports, {"models/cone/__init__.py": "class C:\n    import mujoco\n"}),
    (
        import_contracts.heavy_when_imported,
        {"reports/cli.py": "import plumbob.reports.view.page\n"},
    ),
    (import_contracts.heavy_when_imported, {"reports/cli.py": "raise RuntimeError\n"}),
    (file_contracts.strangers, {"scripts/run.sh": "true\n"}),
    (file_contracts.strangers, {"setup.py": "0\n"}),
    (file_contracts.long_functions, {"analytic/cone.py": functions(22, 60 * "    x = 0\n")}),
    (file_contracts.long_functions, {"analytic/cone.py": functions(120, SIXTEEN)}),
    (file_contracts.silent_files, {"analytic/cone.py": "NAMES = ()\n"}),
    (file_contracts.silent_files, {"analytic/cone.py": '"""Cone."""\nNAMES = ()\n'}),
    (file_contracts.silent_files, {"analytic/cone.py": '# why\n"""What a cone weighs."""\n'}),
    (file_contracts.vague_names, {"engines/utils.py": ""}),
    (file_contracts.vague_names, {"reports/helpers/__init__.py": ""}),
    (file_contracts.module_state, {"engines/method.py": STATE + "METHODS = []\n"}),
    (
        file_contracts.module_state,
        {"engines/method.py": STATE + "METHODS: object = {n: 0 for n in ''}\n"},
    ),
    (file_contracts.module_state, {"engines/method.py": STATE + "class M:\n    known = set()\n"}),
    (file_contracts.module_state, {"engines/method.py": STATE + "if True:\n    M = a.deque()\n"}),
    (
        file_contracts.module_state,
        {"engines/method.py": STATE + "def f():\n    global M\n    M = 1\n"},
    ),
    (file_contracts.incomplete_systems, {"models/bob/__init__.py": ""}),
    (
        file_contracts.incomplete_systems,
        {"models/cone/README.md": "# Cone\n\nof unknown provenance\n"},
    ),
    (file_contracts.missing_files, {"README.md": "see `analytic/sphere.py`\n"}),
    (file_contracts.missing_files, {"models/cone/README.md": "see `models/cone.py` and others\n"}),
    (file_contracts.missing_files, {"analytic/THEORY.md": "see [cones](cylinder.py)\n"}),
    (file_contracts.missing_files, {"models/cone/README.md": "see [it](cone/cone.xml)\n"}),
    (file_contracts.machine_traces, {"README.md": "see /" + "home/me/plumbob\n"}),
    (file_contracts.machine_traces, {"Makefile": "DIR=/" + "tmp/x\n"}),
    (file_contracts.machine_traces, {"Makefile": "pip install --index" + "-url x\n"}),
    (wording.forbidden_words, {"README.md": "The error was foret" + "old.\n"}),
    (wording.forbidden_words, {"engines/method.py": "FINE_RUN" + "GS = ()\n"}),
    (wording.forbidden_words, {"engines/method.py": "class Yard" + "stick: ...\n"}),
    (wording.forbidden_words, {"engines/method.py": "# joints as they\n# " + "come lose energy\n"}),
    (wording.forbidden_words, {"engines/method.py": "# Euler er" + "rs by h\n"}),
    (wording.forbidden_words, {"engines/method.py": "# to " + "err by h\n"}),
)
CONTRACTS = tuple(dict.fromkeys(contract for contract, _ in BROKEN))


def write(root: Path, contents: Mapping[str, str]) -> Path:
    """Write a small tree of files under `root` and return it."""
    for name, text in contents.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, "utf-8")
    return root


@pytest.mark.long
@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.__name__)
def test_contract_holds(contract: Contract) -> None:
    assert not (found := contract(ROOT)), "\n".join(found)


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.__name__)
def test_good_tree_is_left_alone(contract: Contract, tmp_path: Path) -> None:
    assert not (found := contract(write(tmp_path, GOOD))), "\n".join(found)


@pytest.mark.parametrize(
    ("contract", "change"),
    BROKEN,
    ids=[f"{contract.__name__}-{number}" for number, (contract, _) in enumerate(BROKEN)],
)
def test_contract_fails_on_a_broken_tree(
    contract: Contract, change: Mapping[str, str], tmp_path: Path
) -> None:
    assert contract(write(tmp_path, {**GOOD, **change}))
