"""Replays of the capsule seen from above: feet, slider and trail."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.picture import Picture

PAD = 0.2  # margin around the motion, relative to the body's size
FINE = 1601  # samples of the exact motion that determine the extent of the picture


def capsule(case: Case, seconds: float) -> Picture:
    """Returns the picture of a capsule over `seconds` [s], from above, in world axes."""
    exact = motion(case, np.linspace(0.0, seconds, FINE))
    feet = np.asarray(case.problem.setup.capsule.supports) @ [1.0, 1j]
    size = float(np.abs(feet).max())
    place = exact["x"] + 1j * exact["y"]
    turned = np.exp(1j * exact["heading"])
    corners = [place + turned * foot for foot in (*feet, exact["qx"] + 1j * exact["qy"])]
    spans = [(axis.min() - PAD * size, axis.max() + PAD * size) for axis in _parts(corners)]
    return Picture(
        "capsule",
        (*spans[0], *spans[1]),
        {"feet": [*zip(*(axis.tolist() for axis in _parts(feet)), strict=True)], "size": size},
        {"m": size, "rad": 1.0},
        lambda at: motion(case, at),
        lambda run: deviations(case, run),
        lambda off: {"m": np.hypot(off["x"], off["y"]), "rad": np.abs(off["heading"])},
    )


def motion(case: Case, times: Array) -> Signals:
    """Returns the exact channels at `times` [s], shape (n,): the position x, y of C in the world
    [m], the heading [rad], and the position qx, qy of the slider in the body [m]."""
    observed = case.reference.observe(times)
    x, y = _parts(_in_world(case.problem.setup, observed))
    where = case.problem.motion.path.kinematics(times)[0]
    return {
        "x": x,
        "y": y,
        "heading": observed["heading"],
        "qx": where[:, 0],
        "qy": where[:, 1],
    }


def deviations(case: Case, run: Trajectory) -> Signals:
    """Returns the differences of a run from the exact channels, at the run's times. If the run does
    not observe the slider, the slider's difference is zero."""
    setup = case.problem.setup
    exact = case.reference.observe(run.times)
    apart = {name: run.observables.get(name, of) - of for name, of in exact.items()}
    x, y = _parts(_in_world(setup, apart))
    stroke = apart.get("stroke", np.zeros_like(run.times))
    qx, qy = _parts(stroke * np.exp(1j * setup.direction))
    return {"x": x, "y": y, "heading": apart["heading"], "qx": qx, "qy": qy}


def _parts(places: npt.ArrayLike) -> tuple[Array, Array]:
    return np.real(places), np.imag(places)


def _in_world(setup: CapsuleSetup, observed: Signals) -> npt.NDArray[np.complex128]:
    """Returns the position of C in the world [m], as x + iy, from observables."""
    if "displacement" in observed:
        place = observed["displacement"] + 1j * observed["sideways"]
        return np.asarray(place * np.exp(1j * (setup.heading + setup.direction)))
    return np.asarray((observed["x"] + 1j * observed["y"]) * np.exp(1j * setup.heading))
