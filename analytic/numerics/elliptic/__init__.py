"""Motion in a trigonometric potential in closed form, by Jacobi's functions."""
