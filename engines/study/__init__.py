"""How engines are measured: runs, convergence, order, cost, and the store."""
