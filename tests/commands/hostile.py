"""Hostile input at random: command lines, models, archives of controls, and stores.

    python -m plumbob.tests.commands.hostile [lines|models|archives|stores ...] [COUNT] [SEED]

Each is given to a command in a process of its own. Prints the exit codes and how often each came,
and what is wrong: a defect, a signal, more than a line, a warning, more than a minute of processor
time, or a file that is left; exits 1 where anything is.
"""

import importlib
import io
import json
import pkgutil
import random
import re
import shutil
import sqlite3
import sys
import tempfile
import tomllib
from collections import Counter
from contextlib import closing, redirect_stdout, suppress
from copy import deepcopy
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

import numpy as np

from plumbob.engines.study import store
from plumbob.models.registry import find_system
from plumbob.reports.cli import COMMANDS
from plumbob.tests.commands.test_fuzz import filled, random_words
from plumbob.tests.support.first_verdicts import without_first_verdict
from plumbob.tests.support.forked import ended

MODELS = Path(__file__).parents[2] / "models"
NUMBER = re.compile(r"[-+]?\d+\.?\d*(e[-+]?\d+)?")
LONGEST = 60.0  # [s] of processor time for a command
BUDGET = 600.0  # [s] of processor time: the default of `recommend --budget`
FAR = 600  # [s] of wall time, after which a command is ended
SCENE = "linear-pendulum/overdamped"
METHODS = "ode/dop853,mujoco/rk4"
WORDS = tomllib.loads(Path(__file__).with_name("hostile.toml").read_text("utf-8"))
MOTOR = """<mujoco><worldbody><body pos="0 0 1"><joint name="j" axis="0 1 0"/>
<geom size=".1" pos=".3 0 0"/></body></worldbody><actuator><motor joint="j"/></actuator></mujoco>"""
FACTORS = (-1.0, 0.0, 1e30, 1e-30, 1e3, 1e-3, 1.1)
NUMBERS = (
    "nan",
    "inf",
    "1e308",
    "-1e308",
    "5e-324",
    "0",
    "-0",
    "1",
    "1e10",
    "-2",
    "3000000000",
)
WILD = (
    None,
    True,
    -1,
    1e308,
    float("nan"),
    10**400,
    "",
    "x" * 3000,
    "\0",
    [],
    {},
    [1],
    "Scene",
)


def lines(chosen, folder):
    """A command line with arguments at random, or one that is right with something changed."""
    if chosen.random() < 0.5:
        return random_words(chosen.choice(COMMANDS), chosen)
    words = (
        chosen.choice(WORDS["right"])
        .format(chosen.choice(WORDS["scenes"]), chosen.choice(WORDS["methods"]))
        .split()
    )
    if words[0] in ("solve", "run", "gradient", "stability") and "/" not in words[1]:
        names = find_system(words[1]).parameters
        words += ["--set", f"{chosen.choice(names)}={chosen.choice(WORDS['numbers'])}"]
    elif chosen.random() < 0.7:
        numbered = [k for k, word in enumerate(words) if any(map(str.isdigit, word))]
        place = chosen.choice(numbered or [len(words) - 1])
        changed = NUMBER.sub(lambda _: chosen.choice(WORDS["numbers"]), words[place], count=1)
        words[place] = changed
    if words[0] in ("solve", "run", "gradient", "recommend") and chosen.random() < 0.5:
        words += ["--budget", "5"]
    return words


def models(chosen, folder):
    """A command on a model in which up to five things are changed."""
    names = [*WORDS["files"], *WORDS["models"]]
    name = chosen.choice(names)
    text = WORDS["models"].get(name) or (MODELS / name / f"{name}.xml").read_text("utf-8")
    root = ElementTree.fromstring(text)
    for _ in range(chosen.choice([1, 1, 2, 3, 5])):
        _mutate(root, chosen)
    file = folder / "mutated.xml"
    file.write_bytes(ElementTree.tostring(root))
    audit = ["audit", file.name, "--budget", "1"]
    if (
        rare := chosen.random()
    ) > 0.85:  # the second reads it with every engine: some ten seconds
        return (
            ["settings", "--check", file.name]
            if rare < 0.98
            else ["models", "check", file.name]
        )
    more = chosen.choice(WORDS["audits"])
    return [*audit, *more, *([] if "--contacts" in more else ["--duration", "0.1"])]


def _mutate(root, chosen):
    """Change an attribute, or leave out, repeat or move an element."""
    every = [(parent, child) for parent in root.iter() for child in parent]
    parent, element = chosen.choice(every)
    how = chosen.random()
    if how < 0.1:
        parent.remove(element)
    elif how < 0.2:
        parent.append(element)
    elif how < 0.25:
        chosen.choice(every)[0].append(deepcopy(element))  # never below itself
    elif element.attrib:
        names = sorted(element.attrib)
        numbers = [name for name in names if NUMBER.match(element.get(name))]
        name = chosen.choice(numbers if numbers and chosen.random() < 0.8 else names)
        element.set(name, _other(element.get(name), chosen, root))


def _other(value, chosen, root):
    """Another value of an attribute: its numbers scaled or wild, fewer or more of them, another
    choice, or the name of something else."""
    words = value.split()
    with suppress(ValueError):
        numbers = [float(word) for word in words]
        place = chosen.randrange(len(numbers))
        if chosen.random() < 0.7:
            words[place] = repr(numbers[place] * chosen.choice(FACTORS))
        elif chosen.random() < 0.8:
            words[place] = chosen.choice(NUMBERS)
        else:
            words = words[:-1] if chosen.random() < 0.5 else [*words, words[-1]]
        return " ".join(words)
    for group in WORDS["choices"]:
        if value in group:
            return chosen.choice(group)
    return chosen.choice([element.get("name", "") for element in root.iter()])


def archives(chosen, folder):
    """An audit of a motor under controls that an archive holds."""
    shapes = ((50, 1), (50,), (1, 1), (0, 1), (50, 2), (2, 25, 1), ())
    shape = shapes[0] if chosen.random() < 0.6 else chosen.choice(shapes)
    size = chosen.choice((1.0, 1e-30, 1e30, 1e308))
    drawn = [chosen.uniform(-1.0, 1.0) for _ in range(int(np.prod(shape)))]
    values = np.array(drawn) * size
    for _ in range(chosen.choice((0, 0, 1, 3))):
        if values.size:
            values[chosen.randrange(values.size)] = chosen.choice(
                (np.nan, np.inf, -np.inf, 1e308)
            )
    kinds = (
        "f8",
        "f8",
        "f8",
        ">f8",
        "f4",
        "f2",
        "i8",
        "u1",
        "c16",
        "?",
        "U7",
        "S3",
        "M8[s]",
        "O",
    )
    with np.errstate(all="ignore"):
        values = values.reshape(shape)
        kind = chosen.choice(kinds)
        array = values.astype("i8").astype(kind) if kind == "M8[s]" else values.astype(kind)
    names = (
        ("ctrl",)
        if chosen.random() < 0.9
        else ("ctrl", "time")
        if chosen.random() < 0.5
        else ("x",)
    )
    content = io.BytesIO()
    write = np.savez_compressed if chosen.random() < 0.3 else np.savez
    write(content, **dict.fromkeys(names, array))
    held = bytearray(content.getvalue())
    if chosen.random() < 0.5:
        for _ in range(chosen.choice((1, 1, 8))):
            held[chosen.randrange(len(held))] ^= 1 << chosen.randrange(8)
    if chosen.random() < 0.1:
        del held[chosen.randrange(len(held)) :]
    (folder / "mutated.npz").write_bytes(held)
    return [
        "audit",
        "motor.xml",
        "--ctrl",
        "mutated.npz",
        *["--budget", "1", "--duration", "0.1"],
    ]


def stores(chosen, folder):
    """A command that reads a store in which values are changed, with checksums that are right."""
    shutil.rmtree(folder / "mutated", ignore_errors=True)
    shutil.copytree(folder / "out", folder / "mutated")
    with closing(sqlite3.connect(folder / "mutated" / store.FILE)) as opened, opened:
        rows = opened.execute("select study, key, body from result").fetchall()
        rows = [row for row in rows if row[1] != store.PLAN]
        rows += [row for row in rows if row[1] == store.STUDY] * len(rows)
        for number, key, body in chosen.choices(rows, k=chosen.choice((1, 1, 2, 5))):
            held = json.loads(body)
            _replace(held, chosen)
            row = number, key, json.dumps(held)
            opened.execute(
                "replace into result values (?, ?, ?, ?)", (*row, store._digest(*row))
            )
    wanted = ("--scenes", SCENE, "--methods", METHODS, "--jobs", "1")
    return list(
        chosen.choice(
            [
                ("report", "mutated"),
                ("report", "mutated", "--single", "mutated/one.html"),
                ("compare", "mutated", "out"),
                ("compare", "out", "mutated"),
                ("recommend", SCENE, "--error", "0.01", "--stored", "--out", "mutated"),
                ("validate", *wanted, "--out", "mutated"),
            ]
        )
    )


def _replace(held, chosen):
    """Replace something in plain JSON, at a random depth."""
    at, key = held, None
    parent = None
    for _ in range(chosen.randint(1, 7)):
        keys = (
            list(at) if isinstance(at, dict) else range(len(at)) if isinstance(at, list) else ()
        )
        if not keys:
            break
        parent, key = at, chosen.choice(list(keys))
        at = at[key]
    if parent is None:
        return
    if chosen.random() < 0.2:
        del parent[key]
    else:
        parent[key] = chosen.choice(WILD)


MADE = MappingProxyType(
    {
        "lines": (lines, 400),
        "models": (models, 150),
        "archives": (archives, 200),
        "stores": (stores, 100),
    }
)


def tried(kind, seed, folder):
    """The command line of a random case in a folder, how it ends, and what is wrong with that."""
    chosen = random.Random(f"{kind} {seed}")
    words = MADE[kind][0](chosen, folder)
    before = _files(folder)
    how = ended(words, folder, FAR)
    most = BUDGET if words[0] == "recommend" else LONGEST
    one_line = how.err.count("\n") == 1 or how.out  # a table of several audits has its rows
    wrong = {
        f"code {how.code}": how.code not in (0, 1, 2, 3),
        "no line": how.code == 2 and not one_line,
        "more than a line": how.code == 2 and without_first_verdict(how.err).count("\n") > 1,
        "a warning": "warning" in how.err.casefold(),
        "a file is left": how.code == 2 and _files(folder) != before,
        "a log is left": any(folder.rglob("MUJOCO_LOG.TXT")),
        f"{how.seconds:.0f} s": how.seconds > most and "budget = " not in how.err,
    }
    return words, how, [what for what, holds in wrong.items() if holds]


def _prepared(folder):
    """Fill a folder, and load here what each command would load anew."""
    for top in (
        "reports",
        "engines.audit",
        "engines.sweep",
        "engines.adapters.mujoco",
        "models",
    ):
        package = importlib.import_module(f"plumbob.{top}")
        for module in pkgutil.walk_packages(package.__path__, f"plumbob.{top}."):
            if not module.name.endswith((".sysid", ".__main__")):
                importlib.import_module(module.name)
    filled(folder)
    (folder / "motor.xml").write_text(MOTOR, "utf-8")


def _files(folder):
    return sorted((str(path), path.lstat().st_size) for path in folder.rglob("*"))


def searched(kind, seeds, said=print):
    """How often each exit code came, and the cases that are wrong."""
    codes = Counter()
    wrong = []
    slowest = 0.0
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made) / "files"
        folder.mkdir()
        with redirect_stdout(io.StringIO()):
            _prepared(folder)
        for seed in seeds:
            words, how, why = tried(kind, seed, folder)
            codes[how.code] += 1
            slowest = max(slowest, how.seconds)
            if why:
                wrong.append(f"{kind} {seed}: {', '.join(why)}: {words}: {how.err[-300:]}")
                said(wrong[-1], flush=True)
    said(f"{kind}: {dict(sorted(codes.items()))}, the slowest {slowest:.3g} s", flush=True)
    return codes, wrong


def main(words):
    """Search by command line; returns the exit code."""
    numbers = [int(word) for word in words if word.isdecimal()]
    kinds = [word for word in words if word in MADE] or list(MADE)
    first = numbers[1] if len(numbers) > 1 else 0
    found = []
    for kind in kinds:
        count = numbers[0] if numbers else MADE[kind][1]
        found += searched(kind, range(first, first + count))[1]
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
