"""Pulses, the results of simulations and theories, and their comparison."""
