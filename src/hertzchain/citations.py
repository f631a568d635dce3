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
    "The independent-collision theory (hard_sphere):\n"
    "  S. Sen, F. S. Manciu, M. Manciu, Physica A 299, 551 (2001).\n"
    "  R. Doney, S. Sen, Phys. Rev. E 72, 041304 (2005), doi:10.1103/PhysRevE.72.041304.",
    "The solitary wave of equal beads, its tail and its approximations:\n"
    "  J. M. English, R. L. Pego, Proc. Am. Math. Soc. 133, 1763 (2005),\n"
    "  doi:10.1090/S0002-9939-05-07851-2.\n"
    "  A. Chatterjee, Phys. Rev. E 59, 5912 (1999), doi:10.1103/PhysRevE.59.5912.\n"
    "  V. F. Nesterenko, J. Appl. Mech. Tech. Phys. 24, 733 (1983), doi:10.1007/BF00905892.\n"
    "  S. Sen, M. Manciu, Phys. Rev. E 64, 056605 (2001), doi:10.1103/PhysRevE.64.056605.",
    "Waves in precompressed chains:\n"
    "  C. Coste, E. Falcon, S. Fauve, Phys. Rev. E 56, 6104 (1997),\n"
    "  doi:10.1103/PhysRevE.56.6104.\n"
    "  N. Boechler, G. Theocharis, S. Job, P. G. Kevrekidis, M. A. Porter, C. Daraio,\n"
    "  Phys. Rev. Lett. 104, 244302 (2010), doi:10.1103/PhysRevLett.104.244302.\n"
    "  G. Theocharis, M. Kavousanakis, P. G. Kevrekidis, C. Daraio, M. A. Porter,\n"
    "  I. G. Kevrekidis, Phys. Rev. E 80, 066601 (2009), doi:10.1103/PhysRevE.80.066601.\n"
    "  H. Matsuda, K. Ishii, Prog. Theor. Phys. Suppl. 45, 56 (1970), doi:10.1143/PTPS.45.56.\n"
    "  M. Kappus, F. Wegner, Z. Phys. B 45, 15 (1981), doi:10.1007/BF01294272.\n"
    "  I. F. Herrera-Gonzalez, J. A. Mendez-Bermudez, arXiv:2210.12561.",
    "Odd beads and interfaces:\n"
    "  E. Hascoet, H. J. Herrmann, Eur. Phys. J. B 14, 183 (2000), doi:10.1007/s100510050119.\n"
    "  V. F. Nesterenko, C. Daraio, E. B. Herbold, S. Jin, Phys. Rev. Lett. 95, 158702 (2005),\n"
    "  doi:10.1103/PhysRevLett.95.158702, arXiv:cond-mat/0506349.\n"
    "  S. Job, F. Melo, A. Sokolow, S. Sen, arXiv:0712.0006.\n"
    "  S. Job, F. Santibanez, F. Tapia, F. Melo, Phys. Rev. E 80, 025602 (2009),\n"
    "  arXiv:0901.3532.\n"
    "  A. M. Tichler, L. R. Gomez, N. Upadhyaya, X. Campman, V. F. Nesterenko, V. Vitelli,\n"
    "  Phys. Rev. Lett. 111, 048001 (2013), doi:10.1103/PhysRevLett.111.048001,\n"
    "  arXiv:1303.5890.",
    "Disorder:\n"
    "  L. Ponson, N. Boechler, Y. M. Lai, M. A. Porter, P. G. Kevrekidis, C. Daraio,\n"
    "  Phys. Rev. E 82, 021301 (2010), doi:10.1103/PhysRevE.82.021301, arXiv:0904.0426.",
    "Dimers, and small beads between large ones:\n"
    "  K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E 83, 036606 (2011),\n"
    "  doi:10.1103/PhysRevE.83.036606.\n"
    "  U. Harbola, A. Rosas, A. H. Romero, M. Esposito, K. Lindenberg,\n"
    "  Phys. Rev. E 80, 051302 (2009), arXiv:0909.2627.\n"
    "  R. L. Doney, S. Sen, Phys. Rev. Lett. 97, 155502 (2006),\n"
    "  doi:10.1103/PhysRevLett.97.155502.",
    "Loss laws:\n"
    "  Viscoelastic: G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26, 1230 (1987),\n"
    "  doi:10.1143/JJAP.26.1230; N. V. Brilliantov, F. Spahn, J.-M. Hertzsch, T. Poeschel,\n"
    "  Phys. Rev. E 53, 5382 (1996), doi:10.1103/PhysRevE.53.5382.\n"
    "  Restitution: Y. Tsuji, T. Tanaka, T. Ishida, Powder Technol. 71, 239 (1992),\n"
    "  doi:10.1016/0032-5910(92)88030-L.\n"
    "  ElasticPlastic: C. Thornton, J. Appl. Mech. 64, 383 (1997), doi:10.1115/1.2787319.\n"
    "  WaltonBraun: O. R. Walton, R. L. Braun, J. Rheol. 30, 949 (1986),\n"
    "  doi:10.1122/1.549893.\n"
    "  UnloadingRatio: S. Sen, J. Hong, J. Bang, E. Avalos, R. Doney, Phys. Rep. 462, 21\n"
    "  (2008), doi:10.1016/j.physrep.2007.10.007.\n"
    "  Dashpot: A. Rosas, A. H. Romero, V. F. Nesterenko, K. Lindenberg, Phys. Rev. Lett. 98,\n"
    "  164301 (2007), doi:10.1103/PhysRevLett.98.164301.\n"
    "  VelocityPower: R. Carretero-Gonzalez, D. Khatri, M. A. Porter, P. G. Kevrekidis,\n"
    "  C. Daraio, Phys. Rev. Lett. 102, 024102 (2009), doi:10.1103/PhysRevLett.102.024102.",
    f"This software:\n  hertzchain {__version__}; see CITATION.cff.",
)
