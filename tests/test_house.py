"""The folder contracts hold for this tree, and each goes red on a tree that breaks it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from tests import house_files, house_imports

ROOT = Path(__file__).parent.parent
Contract = Callable[[Path], list[str]]

GOOD = {
    "analytic/__init__.py": "",
    "analytic/cone.py": '"""What a cone weighs."""\nimport numpy\nNAMES = ("a", "b")\n',
    "models/__init__.py": "",
    "models/cone/__init__.py": '"""The cone as a system."""\nfrom analytic.cone import NAMES\n',
    "models/cone/README.md": "# Cone\n\n## Provenance\n\nhttps://example.org/home/cone\n",
    "models/cone/cone.xml": "<mujoco/>",
    "models/cone/scene.xml": "<mujoco/>",
    "models/cone/cone.png": "",
    "engines/__init__.py": "",
    "engines/mujoco_adapter.py": '"""Scenes in MuJoCo\'s terms."""\nimport mujoco\n',
    "reports/__init__.py": "",
    "reports/page.py": '"""The page, all of it."""\nimport models.cone, plotly\n',
    "reports/cli.py": '"""The command line itself."""\ndef main():\n    import reports.page\n',
}
STATE = '"""Keeps a register."""\n'

# contract, and the smallest changes to a good tree that break it
TEETH: tuple[tuple[Contract, Mapping[str, str]], ...] = (
    (house_imports.wrong_way, {"analytic/cone.py": "import models.cone\n"}),
    (house_imports.wrong_way, {"models/cone/__init__.py": "from engines import mujoco_adapter\n"}),
    (house_imports.wrong_way, {"engines/late.py": "def f():\n    from reports.page import x\n"}),
    (house_imports.wrong_way, {"models/cone/up.py": "from ...engines import method\n"}),
    (house_imports.wrong_way, {"reports/spy.py": "import tests.tree\n"}),
    (house_imports.foreign_libraries, {"analytic/cone.py": "import pandas\n"}),
    (house_imports.foreign_libraries, {"analytic/cone.py": "def f():\n    import mujoco\n"}),
    (
        house_imports.circles,
        {
            "models/a.py": "from models.b import x\n",
            "models/b.py": "def f():\n    from . import a\n",
        },
    ),
    (house_imports.heavy_imports, {"engines/method.py": "import mujoco\n"}),
    (house_imports.heavy_imports, {"engines/mujoco_adapter.py": "from pymunk import Body\n"}),
    (
        house_imports.heavy_imports,
        {"reports/cli.py": "try:\n    import plotly.io\nfinally:\n    0\n"},
    ),
    (house_imports.heavy_imports, {"models/cone/__init__.py": "class C:\n    import mujoco\n"}),
    (house_imports.heavy_when_imported, {"reports/cli.py": "import reports.page\n"}),
    (house_imports.heavy_when_imported, {"reports/cli.py": "raise RuntimeError\n"}),
    (house_files.strangers, {"scripts/run.sh": "true\n"}),
    (house_files.strangers, {"setup.py": "0\n"}),
    (house_files.long_files, {"analytic/cone.py": '"""What a cone weighs."""\n' + 249 * "0\n"}),
    (house_files.silent_files, {"analytic/cone.py": "NAMES = ()\n"}),
    (house_files.silent_files, {"analytic/cone.py": '"""Cone."""\nNAMES = ()\n'}),
    (house_files.silent_files, {"analytic/cone.py": '# why\n"""What a cone weighs."""\n'}),
    (house_files.vague_names, {"engines/utils.py": ""}),
    (house_files.vague_names, {"reports/helpers/__init__.py": ""}),
    (house_files.module_state, {"engines/method.py": STATE + "METHODS = []\n"}),
    (
        house_files.module_state,
        {"engines/method.py": STATE + "METHODS: object = {n: 0 for n in ''}\n"},
    ),
    (house_files.module_state, {"engines/method.py": STATE + "class M:\n    known = set()\n"}),
    (house_files.module_state, {"engines/method.py": STATE + "if True:\n    M = a.deque()\n"}),
    (
        house_files.module_state,
        {"engines/method.py": STATE + "def f():\n    global M\n    M = 1\n"},
    ),
    (house_files.incomplete_systems, {"models/bob/__init__.py": ""}),
    (
        house_files.incomplete_systems,
        {"models/cone/README.md": "# Cone\n\nof unknown provenance\n"},
    ),
    (house_files.machine_traces, {"README.md": "see /" + "home/me/plumbob\n"}),
    (house_files.machine_traces, {"Makefile": "DIR=/" + "tmp/x\n"}),
    (house_files.machine_traces, {"Makefile": "pip install --index" + "-url x\n"}),
)
CONTRACTS = tuple(dict.fromkeys(contract for contract, _ in TEETH))


def write(root: Path, contents: Mapping[str, str]) -> Path:
    """Write a small tree of files under `root` and return it."""
    for name, text in contents.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, "utf-8")
    return root


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.__name__)
def test_contract_holds(contract: Contract) -> None:
    assert not (found := contract(ROOT)), "\n".join(found)


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.__name__)
def test_good_tree_is_left_alone(contract: Contract, tmp_path: Path) -> None:
    assert not (found := contract(write(tmp_path, GOOD))), "\n".join(found)


@pytest.mark.parametrize(
    ("contract", "change"),
    TEETH,
    ids=[f"{contract.__name__}-{number}" for number, (contract, _) in enumerate(TEETH)],
)
def test_broken_tree_goes_red(
    contract: Contract, change: Mapping[str, str], tmp_path: Path
) -> None:
    assert contract(write(tmp_path, {**GOOD, **change}))
