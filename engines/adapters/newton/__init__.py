"""Newton as an engine: Featherstone's algorithm for trees, XPBD for contacts and loops, and MuJoCo
Warp, in single precision, on the processor or the GPU that Warp chooses.

Newton compiles its kernels when they are first called. Every module but this one imports Newton
when it is imported.
"""

from __future__ import annotations

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import ModelReader, RunsFiles
from plumbob.engines.adapters.hinged_body import model_error
from plumbob.engines.adapters.mjwarp import start_warp
from plumbob.engines.adapters.ported import SINGLE
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import Case, later

STEP = Scheme(EULER, "start", tangent_turn=True, unit=SINGLE)
# Next to a barrier, and of stiff modes, the rounding of single precision has no theory here.
PENDULUMS = (
    *("simple-pendulum/free-large", "simple-pendulum/damped-*", "simple-pendulum/forced-large"),
    *("linear-pendulum/forced-large", "linear-pendulum/overdamped"),
    *("cone-pendulum/rotating-base", "servo/joint-damped", "servo/motor-damped"),
)
TREES = ("projectile", "n-pendulum", "heavy-top", "free-body")
METHODS = (
    Method(
        "newton/featherstone",
        STEP,
        1,
        settings={"solver": "featherstone", "angular_damping": 0.0},
        systems=(*PENDULUMS, *TREES),
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    start_warp()
    simulation: Simulation = later(f"{__name__}.simulation.prepare")(case, method, step)
    return simulation


ENGINE = Engine(
    "newton",
    "newton",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        ModelReader(later(f"{__name__}.user_model.model_fields")),
        RunsFiles(later(f"{__name__}.user_model.user_model"), 2.0**-24),
    ),
)
