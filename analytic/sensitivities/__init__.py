"""Exact sensitivities: derivatives of exact motions by parameters and by the initial state.

A parameter's neighbours (`neighbours`) are the same problem with the parameter moved a little.
Derivatives by the parameter follow from a stencil of order 8: of a smooth motion's equations, start
and observables, evaluated on the motion itself, or of the neighbours' own motions.

    smooth motions           `smooth_motion`, the variational equation
    the capsule              `phases`, stencils of the motion in each of its phases
"""
