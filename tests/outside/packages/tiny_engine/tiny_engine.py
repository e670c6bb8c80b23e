"""An engine of one's own: semi-implicit Euler for free pendulums."""

import math

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.adapters.stepping import Built, stepped
from plumbob.engines.method import Engine, Method


def prepare(case, method, step):
    pendulum = case.problem

    def build():  # the scene at its start; an engine's own model would be built here
        state = [pendulum.theta, pendulum.theta_dot]

        def advance(first, last):  # the steps from one sample to the next
            for _ in range(first, last):
                state[1] -= step * pendulum.gravity / pendulum.length * math.sin(state[0])
                state[0] += step * state[1]

        return Built(advance, lambda: {"theta": state[0], "theta_dot": state[1]})

    return stepped(case, step, build)


ENGINE = Engine(
    name="tiny",
    package="math",  # what has to be installed for it
    methods=(Method("tiny/euler", Scheme(EULER), 1, systems=("simple-pendulum/free-*",)),),
    prepare=prepare,
    model_error=lambda case, method, step: {},  # what the model adds, whatever the step
    not_read={"tension": "no rod pulls in an equation of the angle"},
)
