"""Integration of the equations of motion of all beads, and evaluation of runs.

- integration: `simulate` by adaptive or `fixed_steps`, its `saved_times` and `frames`;
- input of the compiled loop: `kernel_input`, `kernel_laws`, `drive_pieces`, `time_scales`;
- state: `state`, `checked_state`;
- end of a run: `run_end`, `run_message`, `slow_run`;
- forces on walls: `wall_force`, the rule for a complete peak in `wall_watch`, and its bounds in
  `wall_bound`, from `momentum_limits`, and `rebounds`;
- results: `run` and its base classes `trajectory`, `contact_history` and `other_names`, `budget`,
  `largest_overlaps`, `force_table`, `end_forces`, `yielding` with `not_yielded` and `yield_range`,
  `hits`;
- the leading pulse: `run_pulse`, `leading_pulse`, `pulse_width`, `tail`, `missing_values`;
- waves: `waves`, `find_waves`, `wave_events`, `wave_samples`, `unlisted_energy`, `reflection`,
  `find_reflection` between `contact_pairs`, `energy_on_its_way`, `energy_flux`, `energy_balance`,
  `fronts`;
- single beads: `velocity_peaks`, `sensor_force`, `sensor_curve`, `touches`, `sensor_passages`,
  `body_peak`, `body_force` with `resolved_body`, and the rule for its complete peak in
  `body_watch`, with the bound in `body_bound`;
- predictability: `horizon`, `find_horizon`;
- many chains: `simulate_many`, `ensemble_input`, `ensemble_columns`, `ends_of_runs`,
  `run_table`.
"""
