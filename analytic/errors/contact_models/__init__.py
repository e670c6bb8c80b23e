"""Model errors: of contact models, solvers and added inertias, which no smaller step removes."""
