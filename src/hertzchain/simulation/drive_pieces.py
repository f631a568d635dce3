"""Piecewise smooth representation of a drive, for the compiled loop."""

from __future__ import annotations

import math

import numpy as np

from ..chain.drives import Drive, SineBurst, StepDrive, TableDrive
from ..collision import Array


def drive_pieces(drive: Drive | None) -> tuple[Array, Array]:
    r"""A drive as pieces of smooth curves.

    Piece j begins at :math:`t_j` and is, with :math:`s = t - t_j`,

    .. math:: c_0 + c_1 s + c_2 s^2 + c_3 s^3 + \sum_{i=1}^3 a_i \sin \omega_i s .

    A sine under a Hann window of n periods is three sines: with the carrier's angular
    frequency :math:`\omega`,
    :math:`\tfrac{A}{2}\sin\omega s - \tfrac{A}{4}[\sin(\omega + \tfrac{\omega}{n})s
    + \sin(\omega - \tfrac{\omega}{n})s]`.
    """
    if isinstance(drive, StepDrive):
        rest = _cubic(drive.amplitude)
        if drive.rise == 0.0:
            return np.zeros(1), rest[np.newaxis]
        rise = _cubic(0.0, 0.0, 3.0 * drive.amplitude / drive.rise**2,
                      -2.0 * drive.amplitude / drive.rise**3)  # fmt: skip
        return np.array([0.0, drive.rise]), np.array([rise, rest])
    if isinstance(drive, SineBurst):
        amplitude, carrier = drive.amplitude, 2.0 * math.pi * drive.frequency
        burst = _cubic()
        burst[4:6] = amplitude, carrier
        if drive.window == "hann":
            side = carrier / drive.cycles
            burst[4:] = (0.5 * amplitude, carrier, -0.25 * amplitude, carrier + side,
                         -0.25 * amplitude, carrier - side)  # fmt: skip
        if math.isinf(drive.cycles):
            return np.zeros(1), burst[np.newaxis]
        return np.array([0.0, drive.cycles / drive.frequency]), np.array([burst, _cubic()])
    if isinstance(drive, TableDrive):
        return _table_pieces(drive)
    return np.zeros(1), _cubic()[np.newaxis]


def _table_pieces(drive: TableDrive) -> tuple[Array, Array]:
    """Straight lines from time 0; outside the table, the first or last value is used."""
    later = drive.times[drive.times > 0.0]
    starts = np.concatenate(([0.0], later))
    values = drive.value(starts)
    slopes = np.append(np.diff(values) / np.diff(starts), 0.0)
    pieces = np.zeros((len(starts), 10))
    pieces[:, 0], pieces[:, 1] = values, slopes
    return starts, pieces


def _cubic(*coefficients: float) -> Array:
    piece = np.zeros(10)
    piece[: len(coefficients)] = coefficients
    return piece
