"""The measurement of engines: runs, convergence, order, cost, and the store of results."""
