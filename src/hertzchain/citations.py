"""References to cite."""

from __future__ import annotations

from typing import Final

from . import __version__

CITATIONS: Final = (
    "The paper:\n"
    "  L. P. Machado, A. Rosas, K. Lindenberg, Momentum and energy propagation in tapered\n"
    "  granular chains, arXiv:1307.1191.",
    "The binary collision approximation:\n"
    "  A. Rosas, K. Lindenberg, Pulse velocity in a granular chain,\n"
    "  Phys. Rev. E 69, 037601 (2004), doi:10.1103/PhysRevE.69.037601.",
    "The integrator RKN8(6):\n"
    "  J. R. Dormand, M. E. A. El-Mikkawy, P. J. Prince, High-order embedded\n"
    "  Runge-Kutta-Nystrom formulae, IMA J. Numer. Anal. 7, 423 (1987),\n"
    "  doi:10.1093/imanum/7.4.423.",
    "The integrator DOP853, for chains with losses:\n"
    "  E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,\n"
    "  2nd ed. (Springer, 1993), doi:10.1007/978-3-540-78862-1.",
    f"This software:\n  hertzchain {__version__}; see CITATION.cff.",
)
