"""Measured traces: signals with places, units and noise, and files with them.

- the data: `traces` of several `shots`, the `signals` of one, `headers` of columns, and the
  `places` of sensors;
- files: `files`, with the `wanted_columns`;
- what the samples show: `amplitudes`, `crests`, `noise`, `quiet_parts`, `spikes`,
  `missing_rows`, `coupling`, `notes`.
"""
