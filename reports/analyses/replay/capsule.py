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
    centre = exact["x"] + 1j * exact["y"]
    rotation = np.exp(1j * exact["heading"])
    slider = exact["qx"] + 1j * exact["qy"]
    xs, ys = _real_and_imaginary([centre + rotation * point for point in (*feet, slider)])
    pad = PAD * size
    return Picture(
        kind="capsule",
        box=(xs.min() - pad, xs.max() + pad, ys.min() - pad, ys.max() + pad),
        geometry={"feet": [(foot.real, foot.imag) for foot in feet.tolist()], "size": size},
        sizes={"m": size, "rad": 1.0},
        motion=lambda times: motion(case, times),
        deviations=lambda run: deviations(case, run),
        apart=_pose_distance,
    )


def _pose_distance(differences: Signals) -> dict[str, Array]:
    """Returns the distance of C [m] and the angle [rad] between a run and the exact motion."""
    distance = np.hypot(differences["x"], differences["y"])
    return {"m": distance, "rad": np.abs(differences["heading"])}


def motion(case: Case, times: Array) -> Signals:
    """Returns the exact channels at `times` [s], shape (n,): the position x, y of C in the world
    [m], the heading [rad], and the position qx, qy of the slider in the body [m]."""
    observed = case.reference.observe(times)
    x, y = _real_and_imaginary(_in_world(case.problem.setup, observed))
    slider = case.problem.motion.path.kinematics(times)[0]
    return {
        "x": x,
        "y": y,
        "heading": observed["heading"],
        "qx": slider[:, 0],
        "qy": slider[:, 1],
    }


def deviations(case: Case, run: Trajectory) -> Signals:
    """Returns the differences of a run from the exact channels, at the run's times. If the run does
    not observe the slider, the slider's difference is zero."""
    setup = case.problem.setup
    exact = case.reference.observe(run.times)
    differences = {
        name: run.observables.get(name, values) - values for name, values in exact.items()
    }
    x, y = _real_and_imaginary(_in_world(setup, differences))
    stroke = differences.get("stroke", np.zeros_like(run.times))
    qx, qy = _real_and_imaginary(stroke * np.exp(1j * setup.direction))
    return {"x": x, "y": y, "heading": differences["heading"], "qx": qx, "qy": qy}


def _real_and_imaginary(positions: npt.ArrayLike) -> tuple[Array, Array]:
    """Returns x and y of positions x + iy."""
    return np.real(positions), np.imag(positions)


def _in_world(setup: CapsuleSetup, observed: Signals) -> npt.NDArray[np.complex128]:
    """Returns the position of C in the world [m], as x + iy, from observables."""
    if "displacement" in observed:
        place = observed["displacement"] + 1j * observed["sideways"]
        return np.asarray(place * np.exp(1j * (setup.heading + setup.direction)))
    return np.asarray((observed["x"] + 1j * observed["y"]) * np.exp(1j * setup.heading))
