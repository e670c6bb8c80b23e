"""Replays of every quick scene, and a page of them alone, with the runs that they ask for."""

from dataclasses import replace
from functools import cache

import jinja2
import numpy as np

from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.replay import replay, requests
from plumbob.reports.records import notation
from plumbob.reports.view.page import PAGE_TEMPLATES, Plots
from plumbob.tests.support.declared import declared, nothing

PAGE = """{% import "replay.html.jinja" as replays with context %}<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Replays</title>
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>{{ style | safe }}</style></head><body><main id="page"><h1>Replays</h1>
{% for one in shown %}<h2>{{ one.scene }}</h2>{{ replays.replay(one) }}{% endfor %}
</main><script>{{ script | safe }}</script></body></html>"""


def plan():
    """The quick profile."""
    return StudyPlan("quick", find_scenes("*", "quick"), find_methods("*"))


@cache
def recorded(name):
    """A quick scene, with the recordings that its replay shows and nothing else."""
    study = replace(nothing(), scenes=(find_scene(name),), methods=plan().methods)
    return declared(study, requests)


@cache
def replay_of(name):
    """The replay of a quick scene."""
    return replay(recorded(name), find_scene(name))


def write(shown, folder):
    """A page with these replays and nothing else."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(PAGE_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
    )

    def text(name):
        return (PAGE_TEMPLATES / name).read_text("utf-8")

    page = folder / "replays.html"
    page.write_text(
        environment.from_string(PAGE).render(
            shown=shown,
            seconds=notation.seconds,
            plots=Plots(),
            style=text("page.css") + text("replay.css"),
            script=text("page.js") + text("replay.js"),
        ),
        "utf-8",
    )
    return page


def decoded(coded, count):
    """The array of `count` values that a replay's numbers stand for, as the page's script reads
    them."""
    if isinstance(coded, float | int):
        return np.full(count, float(coded))
    numbers = np.array(coded["differences"])
    for _ in range(3):
        numbers = np.cumsum(numbers)
    return np.asarray(coded["low"] + coded["step"] * numbers)
