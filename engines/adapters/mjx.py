"""MJX as an engine: the models of the MuJoCo adapter, stepped by JAX on the processor, in single
precision, which is its default, and in double precision. All steps from one sample to the next are
one compiled loop.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines import sampling
from plumbob.engines.abilities import Batches, OwnDerivative, RunsFiles
from plumbob.engines.adapters.own_derivatives import moved, nudged
from plumbob.engines.adapters.ported import PORTED, built, compiled, model_error, ported
from plumbob.engines.adapters.stepping import Built, SteppedSimulation
from plumbob.engines.method import Engine, Method, Stepping, Unsupported
from plumbob.engines.trajectory import ByName, Trajectory
from plumbob.models.scene import Case, later

if TYPE_CHECKING:
    from plumbob.models.gradient import Number

METHODS = (
    ported("mjx/default", "EULER"),
    ported("mjx/euler+float64", "EULER", float64=True),
    ported("mjx/rk4+float64", "RK4", float64=True),
)


class MjxSimulation(SteppedSimulation):
    """A model on JAX's processor; every run starts afresh, from a state after two steps that JAX
    has compiled. JAX steps on other threads, so that the time is that of the process."""

    def __init__(
        self, translation: Any, model: Any, precise: bool, steps: int, step: float, samples: int
    ) -> None:
        """With MuJoCo's translation and its compiled model, in double precision if `precise`."""
        super().__init__(self._started, steps, step, 0.0, samples=samples, clock="process_time")
        self.translation, self.model, self.precise = translation, model, precise

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges; timed in one go, as to begin
        the steps between two samples takes up to 200 times what they take."""
        with _precision(self.precise):
            done = super().run()
            return replace(done, seconds=super().stepped(done.steps / self.steps).seconds)

    def stepped(self, fraction: float) -> Stepping:
        """The steps of the first `fraction` of the duration alone."""
        with _precision(self.precise):
            return super().stepped(fraction)

    def _started(self) -> Built:
        import jax

        take, (model, state, controls) = _loop(), self.numbers(self.precise)
        once = take(model, state, controls, 0, 1)  # arguments and results have different
        jax.block_until_ready(take(model, once, controls, 1, 2))  # types: two compilations

        def advance(first: int, last: int) -> None:
            nonlocal state
            state = jax.block_until_ready(take(model, state, controls, first, last))

        return built(self.translation, advance, lambda: (state.qpos, state.qvel))

    def numbers(self, precise: bool) -> tuple[Any, Any, Any]:
        """The model, the start, and the controls of all steps, as JAX has them."""
        import jax
        from mujoco import mjx

        kind = np.float64 if precise else np.float32
        begun = {"qpos": self.translation.qpos, "qvel": self.translation.qvel}
        start = mjx.make_data(self.model)
        start = start.replace(**{n: jax.numpy.asarray(v.astype(kind)) for n, v in begun.items()})
        return mjx.put_model(self.model), start, self._controls(kind)

    def _controls(self, kind: type[Any]) -> Any:
        """Controls of all steps, shape (n, nu): of the next power of two of them, so that few
        lengths are compiled."""
        import jax

        if self.translation.control is None:
            return jax.numpy.zeros((1, self.model.nu), dtype=kind)
        times = (np.arange(self.steps) + self.translation.control_at) * self.step
        values: Array = self.translation.control(times)
        rows = np.zeros((1 << (len(values) - 1).bit_length(), values.shape[1]), dtype=kind)
        rows[: len(values)] = values
        return jax.numpy.asarray(rows)


@cache
def _loop() -> Callable[[Any, Any, Any, int, int], Any]:
    """The compiled loop: model, data, controls, and the first and last step."""
    import jax

    def take(model: Any, data: Any, controls: Any, first: Any, last: Any) -> Any:
        return jax.lax.fori_loop(first, last, _step(model, controls), data)

    return jax.jit(take)  # type: ignore[no-any-return]


def _step(model: Any, controls: Any) -> Callable[[Any, Any], Any]:
    """The step with this number, from a state to the next."""
    import jax
    from mujoco import mjx

    last = controls.shape[0] - 1

    def take(n: Any, data: Any) -> Any:
        return mjx.step(model, data.replace(ctrl=controls[jax.numpy.minimum(n, last)]))

    return take


def _precision(double: bool) -> AbstractContextManager[None]:
    import jax

    return jax.enable_x64(double)  # type: ignore[no-any-return]


def prepare(case: Case, method: Method, step: float) -> MjxSimulation:
    """Compile `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    steps = sampling.step_count(case.scene.duration, step)
    begin = time.perf_counter()
    precise = bool(method.settings.get("float64"))
    simulation = MjxSimulation(*compiled(case, method, step), precise, steps, step, case.samples)
    try:
        with _precision(precise):
            simulation.numbers(precise)
    except NotImplementedError as error:
        raise Unsupported(f"MJX refuses the model: {' '.join(str(error).split())}") from None
    simulation.compile_seconds = time.perf_counter() - begin
    return simulation


def batch(
    case: Case, method: Method, step: float, worlds: int
) -> tuple[str, Callable[[int], float]]:
    """So many worlds from the start on, by JAX's vmap."""
    import jax

    simulation = prepare(case, method, step)
    take = jax.jit(jax.vmap(_loop(), (None, 0, None, None, None)))
    with _precision(simulation.precise):
        model, start, controls = simulation.numbers(simulation.precise)
        states = jax.tree.map(lambda x: jax.numpy.broadcast_to(x, (worlds, *x.shape)), start)

    def seconds(steps: int) -> float:
        with _precision(simulation.precise):
            return _seconds(take, model, states, controls, 0, steps)

    return jax.devices()[0].device_kind, seconds


def derivatives(way: str, number: Number, method: Method, step: float) -> ByName:
    """Derivatives of the observables by JAX, forward or backward (`way`) through all steps, of a
    number in the start, the controls or the model; raises Unsupported."""
    import jax

    cases, apart = nudged(number)
    low, here, high = (prepare(case, method, step) for case in cases)
    slopes = _slopes(low, high, apart)
    with _precision(here.precise):
        end = partial(_end, here.numbers(here.precise), slopes, here.steps)
        slope, state = jax.jit(getattr(jax, way)(end, has_aux=True))(0.0)
    qpos, qvel, by_qpos, by_qvel = (np.array(x, np.float64)[None] for x in (*state, *slope))
    return moved(
        lambda q, v: here.translation.observe(qpos + q * by_qpos, qvel + v * by_qvel)[0],
        by_qpos,
        by_qvel,
    )


def _slopes(low: MjxSimulation, high: MjxSimulation, apart: float) -> list[Array]:
    """The derivative of each of the numbers that a run starts with."""
    import jax

    with _precision(True):
        sides = (jax.tree.leaves(simulation.numbers(True)) for simulation in (low, high))
        return [(np.asarray(b, float) - a) / apart for a, b in zip(*sides, strict=True)]


def _end(numbers: Any, slopes: Any, steps: int, amount: Any) -> tuple[Any, Any]:
    """Positions and velocities after so many steps, from numbers moved by an amount of slopes, to
    differentiate and as they are."""
    import jax

    def changed(x: Any, slope: Array) -> Any:
        exact = not jax.numpy.issubdtype(x.dtype, jax.numpy.floating)
        return x if exact else x + amount * slope.astype(x.dtype)

    leaves, structure = jax.tree.flatten(numbers)
    model, start, controls = jax.tree.unflatten(structure, map(changed, leaves, slopes))
    end = jax.lax.fori_loop(0, steps, _step(model, controls), start)
    return (end.qpos, end.qvel), (end.qpos, end.qvel)


def _seconds(take: Any, *arguments: Any) -> float:
    """Time to take steps, compiled before [s]."""
    import jax

    begin = time.perf_counter()
    jax.block_until_ready(take(*arguments))
    return time.perf_counter() - begin


class MjxPort:
    """A compiled model in MJX, in single precision, which is its default."""

    def __init__(self, model: Any) -> None:
        import jax
        from mujoco import mjx

        self.compiled, self.model = model, mjx.put_model(model)
        self.data = mjx.make_data(model)
        self.forwards = jax.jit(mjx.forward)

    def load(self, data: Any) -> None:
        """Take over the state, control and applied forces of an mjData."""
        import jax

        names = ("qpos", "qvel", "act", "ctrl", "qfrc_applied", "qacc_warmstart")
        numbers = {n: jax.numpy.asarray(getattr(data, n), self.data.qpos.dtype) for n in names}
        self.data = self.data.replace(**numbers)

    def forward(self) -> None:
        """Work out all terms."""
        self.data = self.forwards(self.model, self.data)

    def steps(self, count: int) -> None:
        """Take steps."""
        self.data = _loop()(self.model, self.data, self.data.ctrl[None], 0, count)

    def unload(self, data: Any) -> None:
        """Fill in an mjData."""
        from mujoco import mjx

        mjx.get_data_into(data, self.compiled, self.data)


ENGINE = Engine(
    "mjx",
    "mujoco.mjx",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        *(OwnDerivative(way, partial(derivatives, way), 1e-15) for way in ("jacfwd", "jacrev")),
        RunsFiles(partial(later(PORTED), MjxPort), 2.0**-24, integrators=True),
        Batches(batch),
    ),
)
