"""The contracts hold for this tree, and each is red on a tree that breaks it."""

import tomllib
from pathlib import Path

import pytest

from plumbob.tests.contracts import file_contracts, import_contracts, sentences, wording

ROOT = Path(__file__).parents[2]
TREES = tomllib.loads(Path(__file__).with_name("trees.toml").read_text("utf-8"))
GOOD = TREES["good"]
BROKEN = TREES["broken"]
SIXTEEN = "".join(f"    x{number} = 0\n" for number in range(16))


def functions(count, body):
    """A file of so many functions with this body."""
    text = "".join(f"def f{number}():\n{body}" for number in range(count))
    return {"analytic/cone.py": text}


BROKEN["long_functions"] = [functions(22, 60 * "    x = 0\n"), functions(120, SIXTEEN)]
MODULES = (import_contracts, file_contracts, sentences, wording)
EVERY = {name: value for module in MODULES for name, value in vars(module).items()}
CONTRACTS = tuple(EVERY[name] for name in BROKEN)
CASES = tuple((EVERY[name], change) for name, changes in BROKEN.items() for change in changes)


def write(root, contents):
    """Write a small tree of files under `root` and return it."""
    for name, text in contents.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, "utf-8")
    return root


@pytest.mark.long
@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.__name__)
def test_contract_holds(contract):
    assert not (found := contract(ROOT)), "\n".join(found)


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract.__name__)
def test_good_tree_is_left_alone(contract, tmp_path):
    assert not (found := contract(write(tmp_path, GOOD))), "\n".join(found)


@pytest.mark.parametrize(
    ("contract", "change"),
    CASES,
    ids=[f"{contract.__name__}-{number}" for number, (contract, _) in enumerate(CASES)],
)
def test_contract_fails_on_a_broken_tree(contract, change, tmp_path):
    assert contract(write(tmp_path, {**GOOD, **change}))
