"""bouncing-ball: a ball that is dropped and bounces."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Observable, Quantity, scene_of, step_sizes


def facts(ball: BouncingBall) -> Mapping[str, Any]:
    """Returns the times [s] of the first five impacts, the heights [m] of the flights after them,
    and the time of rest [s], None if the ball never rests."""
    times, heights = ball.impacts(np.arange(1.0, 6.0))
    resting = ball.zeno_time if ball.restitution < 1.0 else None
    return {
        "impact_times": times.tolist(),
        "next_heights": heights.tolist(),
        "zeno_time": resting,
    }


_scene = partial(
    scene_of,
    system="bouncing-ball",
    base=field_values(BouncingBall, (1.0, 0.5, 9.81)),
    steps=step_sizes(5e-3, 5e-4),
    source="Falcon et al. 1998, Eur. Phys. J. B 3, 45; the numbers are ours",
)
SYSTEMS = (
    contact_system(
        BouncingBall,
        theory="errors.contact_models.impacts.bouncing_errors",
        model_module=f"{__name__}.model",
        name="bouncing-ball",
        title="Bouncing ball",
        observables=(Observable("z", "m"),),
        scenes=(
            _scene("half", "half of the speed comes back, three times", 1.2, "quick"),
            _scene(
                "to-rest",
                "as half, and on to rest",
                1.5,
                hard="infinitely many impacts end at 1.35 s",
            ),
            _scene("elastic", "all of the speed comes back, for ever", 3.0, restitution=1.0),
            _scene("plastic", "no speed comes back", 1.0, restitution=0.0),
            _scene(
                "lively",
                "nine tenths come back",
                4.0,
                restitution=0.9,
                hard="each impact amplifies errors: a rebound depends on where in a step it begins",
            ),
        ),
        default="half",
        facts=facts,
        # The scale is the height of the start.
        interest=lambda case: (Quantity("z", case.problem.height),),
    ),
)
