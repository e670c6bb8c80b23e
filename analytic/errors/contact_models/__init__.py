"""Model-error terms: what contact models, solvers and added inertias add, apart from the step."""
