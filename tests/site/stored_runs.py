"""The numbers of a stored study, worked out from the rows of its file by code that shares nothing
with the pages."""

import base64
import json
import math
import sqlite3
import zlib
from statistics import median_high

import numpy as np

AT = 1e-3  # [s] step at which the pages compare methods
NEIGHBOUR = 3e-3  # relative distance of the frictions near a scene's, as the finding says


class StoredRuns:
    """The runs, costs and verdicts of the study in a store, read as JSON."""

    def __init__(self, file):
        with sqlite3.connect(file) as store:
            rows = [json.loads(body) for (body,) in store.execute("select body from result")]
        (self.study,) = (row["study"] for row in rows if "study" in row and "results" in row)
        self.varied = [row for row in rows if (row.get("request") or {}).get("changes")]
        answers = [row["answer"] for row in rows if row.get("answer")]
        series = [answer for answer in answers if "measurements" in answer]
        self.series = {(one["scene"], one["method"]): one for one in series}
        self.costs = {
            (answer["scene"], name): cost["ns_per_step"]
            for answer in answers
            if "by_method" in answer
            for name, cost in answer["by_method"].items()
        }
        self.verdicts = {
            (answer["scene"], name): verdict
            for answer in [*answers, *self.study.get("analyses", ())]
            if answer.get("place") == "page of a scene"
            for name, verdict in answer["numbers"]["verdicts"].items()
        }
        self.controls = {method["name"]: method["control"] for method in self.study["methods"]}

    def slopes(self, scene, method, step):
        """The derivatives of a slide's displacement by friction, by central differences of the
        stored runs near the scene's friction, and the exact ones by equation (22) of the source:
        two arrays, relative to the displacement and to the friction."""
        (own,) = (one for one in self.study["scenes"] if one["name"] == scene)
        given = own["parameters"]
        wanted = {"scene": scene, "method": method, "step": step}
        ends = {}
        for row in self.varied:
            if wanted.items() <= row["request"].items():
                ((name, value),) = row["request"]["changes"]
                places = (value / given["friction"] - 1.0) / NEIGHBOUR
                if (
                    name == "friction"
                    and abs(places - round(places)) < 1e-6
                    and abs(places) < 4.5
                ):
                    ends[round(places)] = _last(row["answer"]["observables"]["displacement"])
        places = sorted(ends)
        assert places == list(range(-4, 5))
        frictions = [given["friction"] * (1.0 + NEIGHBOUR * place) for place in places]
        exact = np.array([_displacement(given, friction) for friction in frictions])
        size = 2.0 * NEIGHBOUR * abs(exact[4])
        measured = np.array([ends[place] for place in places])
        return tuple((values[2:] - values[:-2]) / size for values in (measured, exact))

    def error(self, scene, run, when=None):
        """The relative error of a stored run: the largest over the scene's quantities of interest;
        infinite if it diverged. `when` is "end" or "run" in place of each quantity's own."""
        if run["status"] == "diverged":
            return math.inf
        quantities = self.study["interest"][scene]
        errors = [run["errors"][quantity["observable"]] for quantity in quantities]
        return relative_error(
            (error["end"], error["largest"], when or quantity["when"], quantity["scale"])
            for quantity, error in zip(quantities, errors, strict=True)
        )

    def runs(self, scene, method):
        """The runs of a pair that ended or diverged, by step, coarse to fine."""
        runs = self.series[scene, method]["measurements"]
        return {run["step"]: run for run in runs if run["status"] in ("done", "diverged")}

    def run_near(self, scene, method, step):
        """The run of a pair at a printed step, which has four digits at most."""
        runs = self.runs(scene, method)
        nearest = min(runs, key=lambda other: abs(math.log(other / step)))
        assert abs(nearest / step - 1.0) < 1e-3, (scene, method, step)
        return runs[nearest]

    def ms_per_second(self, scene, method, step):
        """The computing time [ms] of a simulated second."""
        run = self.run_near(scene, method, step)
        return 1e-6 * run["steps"] * self.costs[scene, method] / run["duration"]

    def order(self, scene, method, when):
        """The order of an error at the end or over the run, and of its prediction; None where the
        pages show none. At most six of the finest steps count, whose error is above ten times the
        level of rounding and of what the model leaves open."""
        if self.controls[method] == "tolerance":
            return None, None
        points = []
        beside = self.series[scene, method]["beside"]
        for step, run in sorted(self.runs(scene, method).items()):
            if run["status"] != "done" or step in beside:
                continue
            level = max(
                _level(run["errors"][q["observable"]], run["steps"]) / q["scale"]
                for q in self.study["interest"][scene]
            )
            error = self.error(scene, run, when)
            if error > 10.0 * level and len(points) < 6:
                points.append((step, error, self._predicted(scene, run, when)))
        if len(points) < 4:
            return None, None
        steps, errors, predicted = np.log(np.array(points).T)
        known = np.isfinite(predicted).all()
        return (
            np.polyfit(steps, errors, 1)[0],
            np.polyfit(steps, predicted, 1)[0] if known else None,
        )

    def _predicted(self, scene, run, when):
        """The predicted relative error of a run; NaN if a quantity has no prediction."""
        sizes = []
        for quantity in self.study["interest"][scene]:
            predicted = run["errors"][quantity["observable"]]["predicted"]
            if predicted is None or predicted["nonlinearity"] >= 1.0:
                return math.nan
            size = predicted["end" if when == "end" else "largest"]
            sizes.append(abs(size) / quantity["scale"])
        return max(sizes)

    def step_ratio(self, methods, scenes):
        """The median cost of a step of the second method over that of the first, on the scenes
        where all `methods` were timed."""
        timed = [s for s in scenes if all((s, name) in self.costs for name in methods)]
        first, other = ([self.costs[s, name] for s in timed] for name in methods[:2])
        return median_high(other) / median_high(first)


def relative_error(quantities):
    """The largest relative error of a run's quantities, each given by its error at the end, its
    largest error, which of them counts ("end" or "run"), and its scale."""
    return max(
        abs(end if when == "end" else largest) / scale
        for end, largest, when, scale in quantities
    )


def _last(stored):
    """The last number of a stored array."""
    _, text = stored
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), "<f8")[-1]


def _displacement(given, friction):
    """The displacement by one push and one brake [m], equation (22) of the source."""
    fraction = given["slider_mass"] / (given["slider_mass"] + given["body_mass"])
    push, brake = fraction * given["w1"], fraction * given["w2"]
    limit = friction * given["gravity"]
    size = 0.5 * fraction * (given["w1"] + given["w2"]) * given["t1"] ** 2
    return -size * (push - limit) / (brake + limit)


def _level(error, steps):
    """The level of an error below which it is rounding, or the model's: the uncertainty of the
    exact answer grows by four standard deviations of a random walk of half units."""
    return sum(error["model"].values()) + error["uncertainty"] * (1.0 + 2.0 * math.sqrt(steps))
