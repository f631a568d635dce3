"""Coefficients of the Runge-Kutta-Nystrom pair RKN8(6)9FM: order 8, error estimate of order 6.

For x'' = f(x), a step of length h from (x, v) has the stages

    f_s = f(x + c_s h v + h^2 sum_j a_sj f_j),        s = 0..7,

and ends at x + h v + h^2 sum_j b_j f_j and v + h sum_j b'_j f_j.  The ninth stage
is f at the end of the step, the first stage of the next one.

Source: J. R. Dormand, M. E. A. El-Mikkawy and P. J. Prince, "High-order embedded
Runge-Kutta-Nystrom formulae", IMA J. Numer. Anal. 7, 423-430 (1987);
doi:10.1093/imanum/7.4.423.
"""

from __future__ import annotations

C1, C2, C3, C4, C5, C6, C7 = 1 / 20, 1 / 10, 3 / 10, 1 / 2, 7 / 10, 9 / 10, 1.0

# Row s: the weights of the stages before stage s.
A1 = (1 / 800,)
A2 = (1 / 600, 1 / 300)
A3 = (9 / 200, -9 / 100, 9 / 100)
A4 = (-66701 / 197352, 28325 / 32892, -2665 / 5482, 2170 / 24669)
A5 = (
    227015747 / 304251000,
    -54897451 / 30425100,
    12942349 / 10141700,
    -9499 / 304251,
    539 / 9250,
)
A6 = (
    -1131891597 / 901789000,
    41964921 / 12882700,
    -6663147 / 3220675,
    270954 / 644135,
    -108 / 5875,
    114 / 1645,
)
A7 = (
    13836959 / 3667458,
    -17731450 / 1833729,
    1063919505 / 156478208,
    -33213845 / 39119552,
    13335 / 28544,
    -705 / 14272,
    1645 / 57088,
)

# Times of stages 1 to 7, as fractions of the step, and the weights of the stages before each.
C = (C1, C2, C3, C4, C5, C6, C7)
A = (A1, A2, A3, A4, A5, A6, A7)

# Weights of the step.  The weight of stage 1 is 0; stage 7 does not enter the position.
B_POSITION = (223 / 7938, 0.0, 1175 / 8064, 925 / 6048, 41 / 448, 925 / 14112, 1175 / 72576)
B_VELOCITY = (
    223 / 7938,
    0.0,
    5875 / 36288,
    4625 / 21168,
    41 / 224,
    4625 / 21168,
    5875 / 36288,
    223 / 7938,
)

# Difference between the velocities of order 8 and 6, over the nine stages.
E_VELOCITY = (
    223 / 7938 - 7987313 / 109941300,
    0.0,
    5875 / 36288 - 1610737 / 40207104,
    4625 / 21168 - 10023263 / 23454144,
    41 / 224 + 497221 / 6204800,
    4625 / 21168 - 10023263 / 23454144,
    5875 / 36288 - 1610737 / 40207104,
    223 / 7938 + 4251941 / 54970650,
    -3 / 20,
)
