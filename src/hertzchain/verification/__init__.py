"""Compare simulations with exact and published values."""
