"""Description of a chain: beads, materials, losses, walls, drives, strikers; builders, checks.

- the chain: `chain`, its `fields` and `parts`, its description in `chain_words` with
  `description`, its `bead_table`, and its `builders` with their `builder_arguments`;
- methods that return a modified chain: `modifications`, `pieces`, `strikers` with
  `striker_properties`, `impact_speed`, `with_cap` with the `cap`, and `contact_shapes`;
- radii: `tapers`, `taper_sizes`, `random_radii`, `scattered_radii`, `repeated_cells`,
  `decorations`, `changed_tapers`; sizes in figures: `drawn_bodies`;
- masses and contacts: `materials`, `random_materials`, `mass_and_stiffness`, exponents and
  losses `per_contact`, `contact_groups`, and the `laws` of loss;
- ends: `walls`, `drives`, and `boundary_checks` of both with the precompression;
- equilibrium: `static_forces`, `static_state`, `equilibrium`;
- units: `scales`, `conversion`;
- range of the model: `hertz_range` with `hertz_ratios`, `impact_overlaps` and
  `hertz_warnings`, `stiff_walls`, the assumed `yield_pressure`, and `loss_range`;
- input: `input_checks`, `feature_support`, `bead_names`, `places`;
- numerical method: `bisection`.
"""

__all__ = ("laws", "materials")


def __dir__() -> tuple[str, ...]:
    return __all__  # for completion; the other modules are internal
