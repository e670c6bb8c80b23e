"""Results of an unfinished study: known by what defines them, kept when its process ends."""

import multiprocessing
from dataclasses import replace
from functools import partial

from plumbob.engines.registry import method
from plumbob.engines.study import checkpoint, provenance
from plumbob.engines.study.checkpoint import key_of, measured_into
from plumbob.engines.study.cost import SceneCosts
from plumbob.engines.study.provenance import versions_of
from plumbob.engines.study.results import Study, TaskResult
from plumbob.engines.study.store import FILE, load
from plumbob.models.registry import scene
from plumbob.tests.study.disturbed import measures

SCENE = "linear-pendulum/overdamped"


def test_a_key_follows_from_all_that_defines_a_result(monkeypatch):
    one = scene(SCENE)
    rk4 = method("ode/rk4")

    def key(**changed):
        given = {"scene": one, "method": rk4, "most": 1000, **changed}
        return key_of(*given.values(), versions_of(rk4))

    monkeypatch.setattr(provenance, "_version", partial(_changed, ""))
    same = key()
    assert key() == same
    (name, value), *_ = one.parameters.items()
    others = {
        "parameter": key(
            scene=replace(one, parameters={**one.parameters, name: 1.000001 * value})
        ),
        "steps": key(scene=replace(one, steps=one.steps[1:])),
        "settings": key(method=replace(rk4, settings={"other": 1})),
        "most steps": key(most=1001),
    }
    for package in ("plumbob", "scipy", "numpy"):
        with monkeypatch.context() as patched:
            patched.setattr(provenance, "_version", partial(_changed, package))
            others[package] = key()
    monkeypatch.setattr(checkpoint, "_source", lambda: "another file of plumbob")
    others["source"] = key()
    assert len({same, *others.values()}) == 1 + len(others)


def _changed(package, named):
    return "another" if named == package else "1.0"


def test_one_process_measures_into_a_folder_until_it_ends(tmp_path):
    spawning = multiprocessing.get_context("spawn")  # JAX, where installed, allows no fork
    begun = spawning.Event()
    other = spawning.Process(target=measures, args=(tmp_path / FILE, begun), daemon=True)
    other.start()
    notes = []

    def note(what):
        other.kill()  # in the middle of what it does
        notes.append(what)

    assert begun.wait(60.0)
    with measured_into(tmp_path / FILE, note=note) as kept:
        assert notes == ["waits for another process, which measures into the same folder"]
        assert kept.begin("a plan", ["one", "two"])
        assert notes[1:] == ["goes on: 1 of 2 results are there"]
        assert kept.there(["one", "two", "three"]) == {
            "one": TaskResult(SceneCosts("", {}, 1.0))
        }
    assert {file.name for file in tmp_path.iterdir()} == {FILE}


def test_a_result_that_was_given_up_is_open_again(tmp_path):
    lost = TaskResult(label="the first", lost="no memory")
    with measured_into(tmp_path / FILE) as kept:
        kept.begin("a plan", ["one"])
        kept.keep({"one": lost})
        kept.complete(Study("quick", (), ()), {"one": lost})
        assert kept.given_up == ("the first: no memory",)
        number = kept.number
    assert load(tmp_path / FILE) is not None
    with measured_into(tmp_path / FILE) as kept:
        assert kept.begin("a plan", ["one"])
        assert kept.there(["one"]) == {}
        kept.keep({"one": TaskResult()})
        kept.complete(Study("quick", (), ()), {"one": TaskResult()})
        assert (kept.number, kept.given_up) == (number, ())
    with measured_into(tmp_path / FILE) as kept:
        assert not kept.begin("a plan", ["one"])
