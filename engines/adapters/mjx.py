"""MJX as an engine: the models of the MuJoCo adapter, stepped by JAX on the processor, in single
precision, which is its default, and in double precision. All steps from one sample to the next are
one compiled loop.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines import sampling
from plumbob.engines.abilities import Batches, OwnDerivative, RunsFiles
from plumbob.engines.adapters.own_derivatives import moved, nudged
from plumbob.engines.adapters.ported import (
    LOADED,
    PORTED,
    built,
    compiled,
    model_error,
    ported,
    started,
    timed,
)
from plumbob.engines.adapters.stepping import Built, SteppedSimulation
from plumbob.engines.method import Engine, Method, Unsupported
from plumbob.engines.peer_model import RefusedFile
from plumbob.engines.processor_time import processor_time
from plumbob.engines.trajectory import ByName, Trajectory
from plumbob.models.border import border
from plumbob.models.scene import Case, later

if TYPE_CHECKING:
    from plumbob.models.gradient import Number

METHODS = (
    ported("mjx/default", "EULER"),
    ported("mjx/euler+float64", "EULER", float64=True),
    ported("mjx/rk4+float64", "RK4", float64=True),
)


Pair = tuple[Any, Any]
"""A model and its data, or positions and velocities."""


class MjxPort:
    """A compiled model in MJX, in single precision, MJX's default, or in double precision. Raises
    RefusedFile."""

    def __init__(self, model: Any, double: bool = False) -> None:
        import jax
        from mujoco import mjx

        self.precision = partial(jax.enable_x64, double)
        with self.precision(), border(RefusedFile):
            self.compiled, self.model = model, mjx.put_model(model)
            self.data = mjx.make_data(model)
        self.take, self.forwards = _loop(), jax.jit(mjx.forward)

    def load(self, data: Any) -> None:
        """Take over the state, control and applied forces of an mjData."""
        import jax

        kind = self.data.qpos.dtype
        with self.precision():
            loaded = {n: np.array(getattr(data, n), kind) for n in LOADED}
            # Beside others that are on a device a loop is compiled once more for those on none.
            self.data = jax.device_put(self.data.replace(**loaded), self.data.qpos.device)

    def forward(self) -> None:
        """Work out all terms."""
        self.data = self.forwards(self.model, self.data)

    def steps(self, count: int) -> None:
        """Take steps."""
        import jax

        with self.precision():
            self.data = jax.block_until_ready(self.take(self.model, self.data, count))

    @property
    def numbers(self) -> Pair:
        """The model, and where it is."""
        return self.model, self.data

    def state(self) -> Pair:
        """Positions and velocities."""
        return self.data.qpos, self.data.qvel

    def unload(self, data: Any) -> None:
        """Fill in an mjData."""
        from mujoco import mjx

        mjx.get_data_into(data, self.compiled, self.data)


@cache
def _loop() -> Callable[[Any, Any, int], Any]:
    """The compiled loop: model, data, and how many steps."""
    import jax

    return jax.jit(_steps)  # type: ignore[no-any-return]


def _steps(model: Any, data: Any, count: Any) -> Any:
    import jax
    from mujoco import mjx

    return jax.lax.fori_loop(0, count, lambda n, data: mjx.step(model, data), data)


class MjxSimulation(SteppedSimulation):
    """A model in MJX, timed in one go: to begin the steps between two samples takes up to 200 times
    what they take."""

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges."""
        done = super().run()
        return replace(done, seconds=self.stepped(done.steps / self.steps).seconds)


def prepare(case: Case, method: Method, step: float) -> MjxSimulation:
    """Compile `case` for `method` at `step` [s]; raises Unsupported and ParameterError. JAX steps
    on other threads, so that the time is that of the process."""
    steps = sampling.step_count(case.scene.duration, step)
    begin = time.perf_counter()
    translation, model = compiled(case, method, step)

    def build() -> Built:
        port = _started(translation, model, _double(method))
        start = port.data
        port.steps(1)  # compiles
        port.data = start
        return built(port, translation)

    try:
        _started(translation, model, _double(method))
    except RefusedFile as error:
        raise Unsupported(f"MJX refuses the model: {error}") from None
    seconds = time.perf_counter() - begin
    return MjxSimulation(
        build, steps, step, seconds, samples=case.samples, clock=processor_time
    )


def _double(method: Method) -> bool:
    return bool(method.settings.get("float64"))


def _started(translation: Any, model: Any, double: bool) -> MjxPort:
    """A port at the start of a scene."""
    port: MjxPort = started(MjxPort(model, double), translation, model)
    return port


def batch(
    case: Case, method: Method, step: float, worlds: int
) -> tuple[str, Callable[[int], float]]:
    """So many worlds from the start on, by JAX's vmap."""
    import jax

    port = _started(*compiled(case, method, step), _double(method))
    port.take = jax.jit(jax.vmap(_steps, (None, 0, None)))
    with port.precision():
        port.data = jax.tree.map(
            lambda x: jax.numpy.broadcast_to(x, (worlds, *x.shape)), port.data
        )
    return jax.devices()[0].device_kind, partial(timed, port)


def derivatives(way: str, number: Number, method: Method, step: float) -> ByName:
    """Derivatives of the observables by JAX, forward or backward (`way`) through all steps, of a
    number in the start or the model; raises Unsupported."""
    import jax

    cases, apart = nudged(number)
    sides = tuple(compiled(case, method, step) for case in cases)
    slopes = _slopes(sides[0], sides[2], apart)
    port = _started(*sides[1], _double(method))
    with port.precision():
        steps = sampling.step_count(number.case.scene.duration, step)
        end = partial(_end, port.numbers, slopes, steps)
        slope, state = jax.jit(getattr(jax, way)(end, has_aux=True))(0.0)
    qpos, qvel, by_qpos, by_qvel = (np.array(x, np.float64)[None] for x in (*state, *slope))
    return moved(
        lambda q, v: sides[1][0].observe(qpos + q * by_qpos, qvel + v * by_qvel)[0],
        by_qpos,
        by_qvel,
    )


def _slopes(low: Pair, high: Pair, apart: float) -> list[Array]:
    """The derivative of each of the numbers that a run starts with."""
    import jax

    sides = (jax.tree.leaves(_started(*side, True).numbers) for side in (low, high))
    rows = zip(*sides, strict=True)
    return [(np.asarray(b, float) - np.asarray(a, float)) / apart for a, b in rows]


def _end(numbers: Any, slopes: Any, steps: int, amount: Any) -> Pair:
    """Positions and velocities after so many steps, from numbers moved by an amount of slopes, to
    differentiate and as they are."""
    import jax

    def changed(x: Any, slope: Array) -> Any:
        exact = not jax.numpy.issubdtype(x.dtype, jax.numpy.floating)
        return x if exact else x + amount * slope.astype(x.dtype)

    leaves, structure = jax.tree.flatten(numbers)
    model, start = jax.tree.unflatten(structure, map(changed, leaves, slopes))
    end = _steps(model, start, steps)
    return (end.qpos, end.qvel), (end.qpos, end.qvel)


ENGINE = Engine(
    "mjx",
    "mujoco.mjx",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        *(OwnDerivative(way, partial(derivatives, way), 1e-15) for way in ("jacfwd", "jacrev")),
        RunsFiles(partial(later(PORTED), MjxPort), 2.0**-24),
        Batches(batch),
    ),
)
