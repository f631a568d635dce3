r"""Find the universal functions of the local-rate law from our own integration.

Exponential chains, ramps of the rate and the strike at their first bead: nothing else goes in.
The response is fitted in two ways: at the ends of the chain contact by contact, each from the
true state before; within it so that the velocity *added up* along the whole ramp comes out
right (Gauss-Newton), since an error of one contact is passed on to all that follow.

    python -m hertzchain.training 1.5 src/hertzchain/theory/universal_tables
"""
