"""Exact sensitivities: derivatives of exact motions by parameters and by the initial state.

The neighbours of a problem (`neighbours`) are the same problem with one parameter changed a little.
Derivatives by the parameter follow from differences of order 8 between the neighbours. For smooth
motions the differences are between the neighbours' equations, starts and observables, evaluated on
the motion itself. For other motions they are between the neighbours' own motions.

    smooth motions           `smooth_motion`, the variational equation
    the capsule              `phases`, differences of the motion in each of its phases
"""
