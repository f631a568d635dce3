"""Design of chains: a problem, methods that search for chains, and verified results.

- the problem: `problem` and `problem_files`, its `measures`, `objective`, `requirements`,
  `default_limits` and `scatter`;
- variables: `vary`, the continuous `sizes`, the `ball_choice` with its
  `given_diameters`, `balls` of catalogues, `stock`;
- the search: `design`, `methods`, `trials` with their `search_budget`, `dry_run`, and the spaces
  `size_space` and `ball_space`;
- methods for sizes: `scanning`, `quasi_newton`, `bundle_descent`, `evolution`, `smooth_tapers`;
- methods for choices: `genetic` with its `start_rows`; two objectives: `pareto`, `front_search`,
  `dominance`;
- values and derivatives: `measured`, theories in `models`, `exact_gradients`,
  `overlap_slopes`, `finite_differences`, contacts in `yielding`;
- the result: `result`, `verification`, `verified`, `new_samples`, `bounds`, `neighbours`,
  `reference_chains`, `ball_tapers`, `yield_range`, `comparison`, `limits_if_yielding`, `curves`,
  `rejections`, `report`, `allowed_sizes`, `ends_of_search`, `compared_in_words`,
  `sizes_in_words`, `exports`;
- deviations of beads: `sensitivity`, `distribution`, `scatter_causes`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["vary"])
