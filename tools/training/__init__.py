r"""Determine the universal functions of the local-rate law from simulations.

Only exponential chains and ramps of the rate are used, struck at their first bead.  Near both ends
of the chain, the response is fitted contact by contact, each from the simulated previous state.
Within the chain, it is fitted so that the velocity *accumulated* along the whole ramp is accurate
(Gauss-Newton method), because the error of one contact affects all that follow.

    PYTHONPATH=tools python -m training 1.5 src/hertzchain/theory/universal_tables
"""
