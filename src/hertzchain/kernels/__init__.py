"""All compiled code: arrays in, arrays and a status code out.

One file an engine, and no compiled function is called across files: numba's
cache looks at the file of the caller alone, and would go on using an old callee.
For the same reason, touch an engine's file after changing its tableau.
Nothing here raises or prints; the callers turn status codes into errors.
"""
