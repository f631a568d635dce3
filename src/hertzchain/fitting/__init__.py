"""Fit chains to measured traces: materials, losses and gaps, with errors.

- the fit: `fit` with its `settings`, the `model` and the `problem` of `least_squares`, its
  `starts`, and `clocks` that are known;
- parameters: `names`, `parameters`, `chain_parameters`, `law_parameters` with
  `loss_values`, `material_parameters`, `gain_units`;
- predicted signals: `simulations`, `symmetry` of chains, `jumps` of forces, and the model of
  `sensors`;
- errors: `uncertainty`, `weights` and `autocorrelation` of samples, `goodness`,
  `weak_directions`, `flat_valleys`, `held_by_priors`, `posterior`, and the `forecast` for a
  planned experiment with `planned_gains` and `planned_notes`;
- systematic errors: `systematics` with `effect_limits`, `sensor_effects`, `signal_noise`, and
  `constants` that are taken as exact;
- fits that mean less than they seem to: `diagnosis` with its `steps` and `causes`,
  `static_causes`, `constant_causes`, `free_causes`, `row_causes`, `gap_causes` with `rough_gaps`
  and `end_gaps`, `ball_counts`, `ball_count_causes`, `common_effects`, `advice` and
  `second_pulse`, `plausibility`, `prior_conflicts`, `without_priors`, `cap_notes`,
  `unused_parameters`, `silent_sensors`, `dead_channels`;
- the result: `result`, `result_text`, `result_document`, `shown_values`, `summary_width`,
  `fitted_file`;
- further questions: `fitted_restitution`, `loss_comparison` of all `loss_laws`, and `defect_scan`
  with its `defect_fits`;
- data compared with a simulation, without a fit: `compare_traces`, `compared_run`,
  `trace_comparison`,
  `sensor_comparison`, `crossings`, `time_offsets`, `arrival_notes`, `odd_sensors`,
  `ball_count_notes`, `comparison_notes`, `first_pulses`, `compared_part`, `coarse_sampling`;
- data that are read in another way: `misread_columns`, `misread_places`, `misread_times`,
  `exchanged_columns`;
- the shipped data: `example_experiment`.
"""
