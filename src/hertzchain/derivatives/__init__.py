"""Exact derivatives of simulated quantities, by the discrete adjoint of the integration."""
