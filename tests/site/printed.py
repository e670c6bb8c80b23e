"""The numbers that the pages of a site print, read back and compared with the stored runs."""

import html
import math
import re
from collections import Counter
from typing import NamedTuple

from plumbob.tests.site.stored_runs import AT
from plumbob.tests.support.page_document import folded

NUMBER = r"-?\d[\d,]*(?:\.\d+)?(?:e-?\d+)?"
ERROR = rf"{NUMBER}(?: %|×)?|diverged|no number"
STEP = rf"({NUMBER}) s"
METHOD = r"[a-z]+/[\w+-]+"
SIGNS = {"=": "predicted", "↓": "converges", "◆": "limit", "?": "unclaimed", "✗": "unexpected"}


class Compared(NamedTuple):
    """A number that a page prints, and what the stored runs give."""

    kind: str  # what the number is: "error", "tenth", …
    place: str  # the page, and what stands there
    printed: str
    stored: float


def agrees(one):
    """Whether a printed number is the stored one, to half a unit of its last digit."""
    if one.printed in ("diverged", "none"):
        return math.isinf(one.stored)
    text = one.printed.replace(",", "").strip()
    scale = 0.01 if text.endswith("%") else 1.0
    digits = text.rstrip(" %×")
    mantissa, _, exponent = digits.partition("e")
    last = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    if "." not in mantissa and one.kind in ("tenth", "times"):  # two digits: 80,000
        last = 10.0 ** max(len(mantissa.lstrip("-")) - 2, 0)
    # what is 5 in the next digit may be rounded either way
    return abs(float(digits) - one.stored / scale) <= 0.5000001 * last


def plain(markup):
    """The text of a piece of HTML."""
    markup = re.sub(r"<(script|style|svg)\b.*?</\1>|<wbr>", "", markup, flags=re.S)
    return html.unescape(re.sub(r"<[^>]+>", "", markup)).replace("\u00a0", " ")


def tables(markup):
    """The tables of a piece of HTML: {caption: rows of (text, attributes) cells}."""
    found = {}
    for table in re.findall(r"<table>(.*?)</table>", markup, re.S):
        caption = plain(re.search(r"<caption[^>]*>(.*?)</caption>", table, re.S)[1]).strip()
        body = table.partition("</caption>")[2]
        rows = [
            [(plain(text).strip(), given) for given, text in _cells(row)]
            for row in re.split(r"<tr>", body)[1:]
        ]
        found[caption] = rows
    return found


def _cells(row):
    return re.findall(r"<t[dh]\b([^>]*)>(.*?)(?=<t[dh]\b|<tbody>|</t|$)", row, re.S)


class Site:
    """The text of a site's pages, and the comparisons of what they print."""

    def __init__(self, index, stored):
        self.stored = stored
        self.pages = {"index": index.read_text("utf-8")}
        for file in sorted((index.parent / "pages").glob("*.html")):
            self.pages[file.stem] = file.read_text("utf-8") + "".join(folded(file))

    def compared(self):
        """Every number that is printed of the runs, with the stored one."""
        for scene in {scene for scene, _ in self.stored.series}:
            page = scene.replace("/", "-")
            yield from self._sentences(page, scene)
            yield from self._errors(page, scene)
            yield from self._costs(page, scene)
            yield from self._runs(page, scene)
            yield from self._recommended(page, scene)
        yield from self._matrix()
        yield from self._counts()
        yield from self._settings()
        yield from self._displacement()
        yield from self._derivative()

    def _sentences(self, page, scene):
        """Errors, factors and costs in the sentences at the top of a scene's page."""
        text = plain(re.search(r'<div class="lead">(.*?)</div>', self.pages[page], re.S)[1])
        for sentence in filter(str.strip, text.split("\n")):
            method = re.search(METHOD, sentence)[0]
            own = re.search(rf"{METHOD} at {STEP}", sentence)
            step = float(own[1]) if own else None
            for error, at in re.findall(rf"error is ({ERROR}) at {STEP}", sentence):
                step = step or float(at)
                run = self.stored.run_near(scene, method, float(at))
                yield Compared(
                    "error", f"{page}: {method}", error, self.stored.error(scene, run)
                )
            tenth = re.search(
                rf"a tenth of the step, {STEP}, divides it by ({NUMBER})", sentence
            )
            if tenth:
                coarse, fine = (self._error(scene, method, h) for h in (step, float(tenth[1])))
                yield Compared("tenth", f"{page}: {method}", tenth[2], coarse / fine)
            yield from self._costs_said(page, scene, sentence)
            if sentence.startswith("Recommended for"):
                yield from self._of_runs(page, scene, sentence)

    def _of_runs(self, page, scene, sentence):
        """Whether a recommendation says that it is of the steps that were run: the command
        `recommend`, which stands on the page too, tries further steps and so finds cheaper ones."""
        said = "of the steps that were run" in sentence
        method, step = re.search(rf"({METHOD}) at {STEP}", sentence).groups()
        was_run = any(
            abs(float(step) / run - 1.0) < 1e-3 for run in self.stored.runs(scene, method)
        )
        yield Compared("of runs", f"{page}: {method}", str(int(said)), float(was_run))

    def _costs_said(self, page, scene, sentence):
        """The costs in a sentence, each behind its method and step."""
        choice = rf"({METHOD}) at {STEP} \("
        computing = rf"({NUMBER}) ms of computing per simulated second"
        said = rf"{choice}{computing}, ({NUMBER})× real time"
        for name, at, ms, times in re.findall(said, sentence):
            stored = self.stored.ms_per_second(scene, name, float(at))
            yield Compared("ms", f"{page}: {name}", ms, stored)
            yield Compared("real time", f"{page}: {name}", times, 1e3 / stored)
        usual = rf"computing time of the default settings at ({NUMBER}) ms"
        more = rf"{choice}[^)]*?, ({NUMBER}) times the {usual}"
        for name, at, ratio, usual_ms in re.findall(more, sentence):
            ms = self.stored.ms_per_second(scene, name, float(at))
            default = self.stored.ms_per_second(scene, "mujoco/euler", 1e-3 * float(usual_ms))
            yield Compared("times", f"{page}: {name}", ratio, ms / default)

    def _error(self, scene, method, step):
        return self.stored.error(scene, self.stored.run_near(scene, method, step))

    def _table(self, page, caption):
        (rows,) = (
            r for name, r in tables(self.pages[page]).items() if name.startswith(caption)
        )
        return rows

    def _errors(self, page, scene):
        """The table of errors, orders and costs."""
        for cells in self._table(page, "Errors at 1 ms")[1:]:
            method, end, way, _, ms, times = [text for text, _ in cells]
            for when, text in (("end", end), ("run", way)):
                if text == "–":
                    continue
                error, step = self._step_said(method, text)
                run = self.stored.run_near(scene, method, step)
                place = f"{page}: {method} {when}"
                yield Compared("error", place, error, self.stored.error(scene, run, when))
                yield from self._orders(place, text, self.stored.order(scene, method, when))
            if ms != "–":
                stored = self.stored.ms_per_second(scene, method, step)
                yield Compared("ms", f"{page}: {method}", ms, stored)
                yield Compared("real time", f"{page}: {method}", times, 1e3 / stored)

    def _orders(self, place, text, orders):
        """The observed and the predicted order of a cell."""
        said = re.search(rf"\n({NUMBER})(?: \(({NUMBER})\))?$", text)
        for k, order in enumerate(orders):
            printed = said[k + 1] if said else None
            missing = order is None and printed is None
            shown = "0" if missing else printed or "none"
            yield Compared("order", place, shown, 0.0 if order is None else order)

    def _step_said(self, method, text):
        """The error and the step of a cell; 1 ms if it says none."""
        first = text.removeprefix("= ").split("\n")[0]
        said = re.search(rf"(?:\n| at )(?:rtol )?({NUMBER})(?: s)?$", text)
        beside = said and (" at " in first or "rtol" in text or text.endswith(" s"))
        return re.match(ERROR, first)[0], float(said[1]) if beside else AT

    def _costs(self, page, scene):
        """The table of costs."""
        for cells in self._table(page, "Cost")[1:]:
            method, ms, _, times, at, _ = [text for text, _ in cells]
            step = float(re.search(NUMBER, at.removeprefix("rtol "))[0])
            stored = self.stored.ms_per_second(scene, method, step)
            yield Compared("ms", f"{page}: costs, {method}", ms, stored)
            yield Compared("real time", f"{page}: costs, {method}", times, 1e3 / stored)

    def _runs(self, page, scene):
        """The table of every run's largest error of the leading observable."""
        leading = self.stored.study["observed"][scene][0]["name"]
        for cells in self._table(page, "Every run")[1:]:
            method = cells[0][0]
            runs = self.stored.series[scene, method]["measurements"]
            for (text, _), run in zip(cells[1:], runs, strict=False):
                if run["status"] == "done" and text != "–":
                    error = run["errors"][leading]["largest"]
                    yield Compared("run", f"{page}: {method} at {run['step']}", text, error)

    def _recommended(self, page, scene):
        """The cheapest method for each error wanted: it reaches that at its step and at all smaller
        ones, and no other run that does so costs less."""
        for cells in self._table(page, "The cheapest method and step")[1:]:
            if "reaches" in cells[1][0]:
                continue
            wanted, method, at, times = [text for text, _ in cells[:4]]
            level = float(wanted.removesuffix(" %")) * (0.01 if "%" in wanted else 1.0)
            step = float(re.search(NUMBER, at.removeprefix("rtol "))[0])
            place = f"{page}: {wanted}"
            finer = [s for s in self.stored.runs(scene, method) if s <= step * 1.001]
            worst = max(self._error(scene, method, s) for s in finer)
            yield Compared("reached", place, "1" if worst <= level else "0", 1.0)
            ms = self.stored.ms_per_second(scene, method, step)
            yield Compared("real time", place, times.removesuffix("×"), 1e3 / ms)

    def _matrix(self):
        """The cells of the table of all scenes, at each of its three steps."""
        for caption, rows in tables(self.pages["index"]).items():
            if ": relative error at 1 ms" not in caption:
                continue
            methods = [text for text, _ in rows[0]][1:]
            for cells in rows[1:]:
                scene = cells[0][0]
                for method, (text, given) in zip(methods, cells[1:], strict=True):
                    if text:
                        yield from self._cell(scene, method, text, given)

    def _cell(self, scene, method, text, given):
        """A cell of the table of all scenes: the error at 1 ms, and those kept for other steps."""
        at_default, largest = re.search(r'data-at="([^"]*)"', given)[1].split("|")
        usual = 2e-3 if self.stored.controls[method] == "step" else 1e-3
        for kept, column in ((text, AT), (at_default, usual), (largest, None)):
            said = html.unescape(kept).partition("~")[0]
            if said:
                error, _, at = said.partition("\n")
                number = re.search(NUMBER, at.removeprefix("rtol "))
                step = float(number[0]) if number else column
                value = self._error(scene, method, step)
                yield Compared("error", f"index: {scene} {method}", error[2:], value)

    def _counts(self):
        """The counts of verdicts on the index, and of cells whose step is too large."""
        text = plain(re.search(r'<p class="tally">(.*?)</p>', self.pages["index"], re.S)[1])
        meanings = Counter(map(_meaning, self.stored.verdicts.values()))
        for sign, count in re.findall(rf"([{''.join(SIGNS)}]) (\d+) ", text):
            yield Compared("count", f"index: {sign}", count, meanings[SIGNS[sign]])
        marked = sum(
            cell[0].startswith("? ")
            for caption, rows in tables(self.pages["index"]).items()
            if ": relative error at 1 ms" in caption
            for row in rows[1:]
            for cell in row[1:]
        )
        said = re.search(r"\? marks (\d+) cell", plain(self.pages["index"]))
        yield Compared("count", "index: ?", said[1] if said else "0", marked)
        runs = sum(len(self.stored.runs(*pair)) for pair in self.stored.series)
        yield Compared("count", "index: runs", re.search(rf"({NUMBER}) runs", text)[1], runs)

    def _settings(self):
        """The number of titles of blocks to copy, for each method: as many as there are blocks."""
        for article in re.findall(
            r'<article class="settings">.*?</article>', self.pages["cheapest"], re.S
        ):
            titles = re.findall(r"<summary>(.*?)</summary>", article)
            title = plain(article.partition("</h3>")[0]).strip()
            yield Compared("blocks", title, str(len(set(titles))), len(titles))

    def _displacement(self):
        """The range of errors of contacts that do not converge, over all steps."""
        text = plain(self.pages["capsule-line"])
        said = re.search(
            rf"have an error of ({NUMBER} %) to ({NUMBER} %) of Δx at every step that was run, "
            rf"from ({NUMBER}) to {STEP}",
            " ".join(text.split()),
        )
        scene = "capsule-line/ca1"
        own = {"mujoco/euler", "mujoco/rk4"} & {name for _, name in self.stored.series}
        runs = [run for name in own for run in self.stored.runs(scene, name).values()]
        errors = [self.stored.error(scene, run, "end") for run in runs]
        steps = [run["step"] for run in runs]
        for printed, stored in zip(
            said.groups(), (min(errors), max(errors), min(steps), max(steps)), strict=True
        ):
            yield Compared("range", "capsule-line: displacement", printed, stored)

    def _derivative(self):
        """The mean errors and the scatter of derivatives through contact."""
        text = " ".join(plain(self.pages["engines"]).split())
        said = re.search(
            rf"derivative by friction is (\d+) % wrong.*?error is ({NUMBER} %) on average at a "
            rf"step of {STEP}, with a scatter of ({NUMBER} %), and ({NUMBER} %) at {STEP}, with "
            rf"({NUMBER} %)\. With contacts written for the step it is ({NUMBER} %) and "
            rf"({NUMBER} %)",
            text,
        )
        title, first, step, scatter, finer, half, finer_scatter, *advised = said.groups()
        steps = float(step), float(half)
        printed = ((first, scatter), (finer, finer_scatter))
        for at, (mean, spread) in zip(steps, printed, strict=True):
            errors, exact = self._slope_errors("mujoco/euler", at)
            yield Compared("derivative", "engines", mean, errors.mean() / exact)
            yield Compared("derivative", "engines", spread, abs(errors.std() / exact))
        yield Compared("derivative", "engines", advised[0], self._mean_error(steps[0]))
        yield Compared("derivative", "engines", advised[1], self._mean_error(steps[1]))
        errors, exact = self._slope_errors("mujoco/euler", steps[0])
        yield Compared("derivative", "engines", f"{title} %", abs(errors.mean() / exact))

    def _mean_error(self, step):
        """The mean relative error of the derivative with contacts written for the step."""
        errors, exact = self._slope_errors("mujoco/euler+coulomb", step)
        return errors.mean() / exact

    def _slope_errors(self, method, step):
        """The errors of a slide's derivatives near its friction, and the exact one at it."""
        measured, exact = self.stored.slopes("capsule-line/heading-030", method, step)
        return measured - exact, exact[3]


def _meaning(verdict):
    """The meaning of a stored verdict to a reader."""
    if verdict["standing"] == "unexpected":
        return "unexpected"
    if verdict["verdict"] in ("unsupported", "missing"):
        return "not run"
    if verdict["standing"] == "known limit" or verdict["verdict"] in (
        "not-converging",
        "diverged",
    ):
        return "limit"
    names = {"pre-asymptotic": "unclaimed", "converges": "converges"}
    return names.get(verdict["verdict"], "predicted")


def commands(pages):
    """The commands that run a scene which the pages print, each once."""
    said = [
        html.unescape(re.sub("<wbr>", "", text))
        for page in pages.values()
        for text in re.findall(r"<code>(plumbob run [^<]*(?:<wbr>[^<]*)*)</code>", page)
    ]
    return list(dict.fromkeys(said))
