"""Numbers: 34 digits, error-free sums, power series, collocation."""
