"""Theories of the leading pulse, a file each: a chain in, a `Pulse` out, nothing integrated."""
