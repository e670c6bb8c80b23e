"""Draw the picture of README.md: the error of a slide over the step, with MuJoCo's default contacts
and with those of `plumbob settings`.

    python -m plumbob.tests.validation.readme_picture

Writes `tests/examples/slide.svg`. Look at it before it is committed."""

from pathlib import Path

from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.models.registry import case_of, scene
from plumbob.reports.view.drawing import svg_drawing
from plumbob.reports.view.page import filled_picture
from plumbob.reports.view.palette import BLUE, RED
from plumbob.reports.view.plotly_figure import curve, figure, logarithmic

FILE = Path(__file__).parents[1] / "examples" / "slide.svg"
SCENE = "capsule-line/heading-030"
METHODS = (
    ("mujoco/euler", "MuJoCo's default contacts", RED),
    ("mujoco/euler+coulomb", "contacts of plumbob settings", BLUE),
)
STEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)  # [s]
NAMED, BELOW = 2, 0.25  # number of the step below which a curve has its name; times its error


def errors_of(name):
    """The relative error of the displacement with a method, at each step."""
    case = case_of(scene(SCENE))
    about = case.system.quantities(case)
    return [
        relative_error(measure(case, method(name), step, theory=False)[0], about)
        for step in STEPS
    ]


def picture():
    """The picture as SVG."""
    traces = []
    for name, words, colour in METHODS:
        errors = errors_of(name)
        traces.append(curve(STEPS, errors, colour=colour, marks=True, size=6, width=2.0))
        place = [STEPS[NAMED]], [BELOW * errors[NAMED]]
        traces.append(curve(*place, hints=[words], labels=True, lines=False))
    # powers of ten, with margins for the names
    axes = logarithmic("step [s]"), logarithmic("relative error of the way", range=(-6.5, 0.5))
    return filled_picture(svg_drawing(figure("", "", traces, *axes, wide=True)))


def main():
    """Write the picture."""
    FILE.write_text(picture(), "utf-8")
    print(FILE)


if __name__ == "__main__":
    main()
