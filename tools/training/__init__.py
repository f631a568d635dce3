r"""Determine the universal functions of the local-rate law from simulations.

The response to slow changes is fitted to ramps of the rate, such that the velocity *accumulated*
along the whole ramp is accurate (Gauss-Newton method), because the error of one contact affects all
that follow.  The first order of fast changes is simulated.  Their second order is fitted to random
chains, and to simulated derivatives.

    PYTHONPATH=tools python -m training 1.5 src/hertzchain/theory/universal_tables build/p1.5

The last folder keeps the results of finished stages, so that an interrupted run can be resumed.
"""
