"""Theories of the leading pulse, one file each: from a chain to a `Pulse`, without integration.

- collisions of single beads: `hard_sphere`, `bca`, and the paper's corrections in `modified_bca`;
  `alternating_masses`, to which they do not apply;
- the local-rate law: `local_rate`, its `universal_functions` and `exponents`, the
  `linear_response`, `steady_rates` of exponential tapers, `growth_errors` of long ones, ends in
  `end_response` and `short_chains`; `piecewise` smooth chains, `strikers` and `lossy_law` with
  `tabulated_losses`; `disorder`;
- small beads between large ones: `decoration`, `effective_chain`;
- the solitary wave: `solitary_wave`, its `solitary_wave_solver`, `wave_profile` and `wave_tail`,
  approximations in `long_wave`, `attenuation` by losses, the `striker_train`;
- small oscillations of compressed chains: `spectrum` and its `band_structure`, `host_bands`,
  `mode_tables`, `linear_contacts`, `eigenmodes`, `response`, `bands`, `dispersion`;
- tables: `table_files`, `packed_tables`, `table_weights`, `loss_table`, `step_table`,
  `striker_table`, `disorder_table`;
- all theories by name: `catalogue`.

`hertzchain` exports the theories themselves; the names here are further functions.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
