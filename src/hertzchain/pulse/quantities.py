"""The table of quantities: the name, symbol, unit and meaning of each, in one row.

`Pulse`, `PulseTable`, comparisons, plots, datasets, files, the command line and sweeps read this
table.  A new quantity is a row here and the code that computes it (how-to guide "Extending").
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from types import MappingProxyType
from typing import Any, Final, Literal

Place = Literal["bead", "contact", "wall", "wave", "sensor", "run"]
Values = Literal["positive", "positive after the strikers", "nonzero", "finite"]


@dataclass(frozen=True)
class Quantity:
    """One row of the table of quantities.

    Attributes
    ----------
    name : str
        Its name everywhere: attribute of `Pulse`, variable of datasets, column of files, option of
        commands.
    symbol : str
        Symbol in plain text, that of the paper if it has one.
    description : str
        Meaning of the quantity, as a noun phrase.
    unit : str
        Unit of a chain in SI units; ``"1"`` if it has none.
    scale : str
        Unit of a scaled chain, in the words of `hertzchain.Scales.unit`.
    label : str
        Label of an axis, with TeX mathematics.
    per : str
        ``"bead"``, ``"contact"``, ``"wall"``, ``"wave"``, ``"sensor"`` or ``"run"``: the object to
        which a value belongs.
    inputs : tuple of str
        Quantities, and arrays of the chain, from which ``formula`` computes it.
    formula : callable or None
        Function of the inputs; it also takes arrays with a leading chain axis.  `None` if
        simulations and theories give the quantity themselves.
    stored : bool
        Whether simulations and theories may give it: True for each quantity without a formula.
        With one, the formula is used where it is not given.
    values : str
        Allowed values, where they are given: ``"positive"``, ``"positive after the strikers"``,
        ``"nonzero"`` or ``"finite"``.
    without_damping : str
        The label if contacts have damping forces, which the quantity excludes; empty for the usual
        one.
    estimate : bool
        Whether only some theories give it, as an estimated error or a spread over random chains;
        it is not compared.
    scored : bool
        Whether the scoreboard evaluates theories by it.
    attribute : str
        Of a quantity of a wall or sensor, the attribute of `WallForce` or `SensorForce` that holds
        it.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.pulse.quantities import QUANTITIES
    >>> QUANTITIES["peak_force"].description
    'largest force on the next bead, without damping forces'
    """

    name: str
    symbol: str
    description: str
    _: KW_ONLY
    unit: str
    scale: str
    label: str = ""
    without_damping: str = ""
    per: Place = "bead"
    inputs: tuple[str, ...] = ()
    formula: Callable[..., Any] | None = None
    stored: bool = False
    values: Values = "positive"
    estimate: bool = False
    scored: bool = False
    attribute: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "stored", self.stored or self.formula is None)

    def count(self, beads: int) -> int:
        """Number of values of a chain: one fewer than beads for quantities per contact.

        Parameters
        ----------
        beads : int
            Number of beads.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.pulse.quantities import QUANTITIES
        >>> QUANTITIES["peak_force"].count(10)
        9
        """
        return beads - (self.per == "contact")

    def unit_in(self, units: str) -> str:
        """Unit of the quantity for a chain in SI units, ``"1"`` for a scaled chain.

        Parameters
        ----------
        units : str
            ``"SI"`` or ``"scaled"``, the units of the chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.pulse.quantities import QUANTITIES
        >>> QUANTITIES["energy"].unit_in("SI"), QUANTITIES["energy"].unit_in("scaled")
        ('J', '1')
        """
        return self.unit if units == "SI" else "1"

    def label_in(self, units: str, *, damped: bool = False) -> str:
        """Label of an axis, with the unit if the chain is in SI units.

        Parameters
        ----------
        units : str
            ``"SI"`` or ``"scaled"``, the units of the chain.
        damped : bool
            Whether contacts between the beads have damping forces.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.pulse.quantities import QUANTITIES
        >>> QUANTITIES["peak_force"].label_in("SI")
        'largest force $F_k$ [N]'
        >>> QUANTITIES["peak_force"].label_in("SI", damped=True)
        'largest force without damping $F_k$ [N]'
        """
        unit, label = self.unit_in(units), (damped and self.without_damping) or self.label
        return label if unit == "1" else f"{label} [{unit}]"

    def attributes(self, units: str) -> dict[str, str]:
        """Attributes of a variable of a dataset.

        Parameters
        ----------
        units : str
            ``"SI"`` or ``"scaled"``, the units of the chain.

        Returns
        -------
        dict of str
            ``long_name`` and, if there are any, ``units`` and ``symbol``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.pulse.quantities import QUANTITIES
        >>> QUANTITIES["arrival"].attributes("SI")["units"]
        's'
        """
        # As in the CF conventions, values without units are dimensionless.
        known = {"units": self.unit_in(units), "long_name": self.description, "symbol": self.symbol}
        return {name: each for name, each in known.items() if each not in ("", "1")}


def _by_name(rows: Iterable[Quantity]) -> Mapping[str, Quantity]:
    return MappingProxyType({row.name: row for row in rows})


# Quantities of the leading pulse, in the order of tables.
QUANTITIES: Final = _by_name(
    (
        Quantity(
            "velocity", "v", "first maximum of the bead's velocity",
            unit="m/s", scale="velocity", label="velocity $v_k$", scored=True,
        ),
        Quantity(
            "momentum", "P", "momentum m v of the bead at that maximum",
            unit="N s", scale="momentum", label="momentum $P_k$", scored=True,
            inputs=("masses", "velocity"), formula=lambda m, v: m * v,
        ),
        Quantity(
            "energy", "E", "kinetic energy m v^2 / 2 of the bead at that maximum",
            unit="J", scale="energy", label="kinetic energy $E_k$", scored=True,
            inputs=("momentum", "velocity"), formula=lambda p, v: 0.5 * p * v,
        ),
        Quantity(
            "peak_time", "t_v", "time of that maximum",
            unit="s", scale="time", label="time of the velocity maximum",
            values="positive after the strikers",
        ),
        Quantity(
            "arrival", "t", "time at which the bead becomes faster than the one behind it",
            unit="s", scale="time", label="arrival time $t_k$", scored=True,
            values="positive after the strikers",
        ),
        Quantity(
            "residence", "T", "time from the arrival at this bead to that at the next bead",
            unit="s", scale="time", label="residence time $T_k$", per="contact",
            # Beads may be reached out of order, but not two of them at the same time.
            values="nonzero", stored=True,
            inputs=("arrival",), formula=lambda t: t[..., 1:] - t[..., :-1],
        ),
        Quantity(
            "peak_overlap", "d", "largest overlap with the next bead",
            unit="m", scale="length", label="largest overlap $d_k$", per="contact",
        ),
        Quantity(
            "peak_force", "F", "largest force on the next bead, without damping forces",
            unit="N", scale="force", label="largest force $F_k$", per="contact",
            without_damping="largest force without damping $F_k$", scored=True,
            inputs=("loading_force", "peak_overlap"), formula=lambda force, d: force(d),
        ),
        Quantity(
            "velocity_spread", "sd_v", "standard deviation of ln v over random chains",
            unit="1", scale="1", label=r"standard deviation of $\ln v_k$",
            estimate=True, values="positive after the strikers",
        ),
        Quantity(
            "arrival_spread", "sd_t", "standard deviation of ln t over random chains",
            unit="1", scale="1", label=r"standard deviation of $\ln t_k$",
            estimate=True, values="positive after the strikers",
        ),
        Quantity(
            "peak_force_spread", "sd_F",
            "standard deviation of ln F over random chains",
            unit="1", scale="1", label=r"standard deviation of $\ln F_k$", per="contact",
            estimate=True,
        ),
        Quantity(
            "velocity_error", "e_v", "estimated relative error of the velocity",
            unit="1", scale="1", label="estimated relative error of $v_k$",
            values="positive after the strikers", estimate=True,
        ),
    )
)  # fmt: skip

# Quantities of the leading pulse that are computed on request; tables and files omit them.
ON_REQUEST: Final = _by_name(
    (
        Quantity(
            "speed", "V", "speed of the pulse from this bead to the next",
            unit="m/s", scale="radius/time", label="speed of the pulse $V_k$", per="contact",
            inputs=("centre_distances", "residence"), formula=lambda apart, t: apart / t,
        ),
    )
)  # fmt: skip
# Every quantity that `Pulse.column` returns.
COLUMN_QUANTITIES: Final[Mapping[str, Quantity]] = MappingProxyType({**QUANTITIES, **ON_REQUEST})

# Quantities of the right wall, which only `simulate` gives.
WALL_QUANTITIES: Final = _by_name(
    (
        Quantity(
            "wall_peak_force", "", "peak force on the right wall",
            unit="N", scale="force", label="peak force on the wall", per="wall",
            attribute="peak",
        ),
        Quantity(
            "wall_peak_time", "", "time of the peak force on the right wall",
            unit="s", scale="time", label="time of the peak force on the wall", per="wall",
            attribute="peak_time",
        ),
        Quantity(
            "wall_largest_so_far", "",
            "largest force on the right wall in the run, complete or not",
            unit="N", scale="force", label="largest force on the wall so far", per="wall",
            attribute="largest_so_far",
        ),
        Quantity(
            "wall_impulse_of_impact", "",
            "impulse of the right wall until the end of the impact",
            unit="N s", scale="momentum", label="impulse of the impact on the wall", per="wall",
            attribute="impulse_of_impact",
        ),
        Quantity(
            "wall_first_contact_impulse", "", "impulse of the first contact with the right wall",
            unit="N s", scale="momentum", label="impulse of the first contact with the wall",
            per="wall", attribute="first_contact_impulse",
        ),
        Quantity(
            "wall_impulse", "", "impulse of the right wall in the whole run",
            unit="N s", scale="momentum", label="impulse of the wall", per="wall",
            attribute="impulse",
        ),
        Quantity(
            "wall_duration", "",
            "impulse of the impact on the right wall over its largest force, without static force",
            unit="s", scale="time", label="impulse / peak of the impact on the wall", per="wall",
            attribute="duration",
        ),
    )
)  # fmt: skip

# Quantities of the last body of a free end, such as an instrument, which only `simulate` and
# `simulate_many` give; without the static force.
BODY_QUANTITIES: Final = _by_name(
    (
        Quantity(
            "body_peak_force", "", "largest force of the last contact on the body behind it",
            unit="N", scale="force", label="largest force on the last body", per="run",
            attribute="force",
        ),
        Quantity(
            "body_peak_time", "", "time of that force",
            unit="s", scale="time", label="time of the largest force on the last body", per="run",
            attribute="time",
        ),
        Quantity(
            "body_acceleration", "", "that force over the mass of the body",
            unit="m/s^2", scale="velocity/time", label="largest acceleration of the last body",
            per="run", attribute="acceleration",
        ),
        Quantity(
            "body_duration", "",
            "time around the largest force for which the force exceeds a tenth of it",
            unit="s", scale="time", label="duration of the force on the last body", per="run",
            attribute="duration",
        ),
    )
)  # fmt: skip

# Quantities of sensors in beads, which only `simulate` and `simulate_many` give.
SENSOR_QUANTITIES: Final = _by_name(
    (
        Quantity(
            "sensor_first_maximum", "", "first maximum of the force in the sensor",
            unit="N", scale="force", label="first maximum of the force", per="sensor",
            attribute="first_maximum",
        ),
        Quantity(
            "sensor_first_maximum_time", "", "time of that maximum",
            unit="s", scale="time", label="time of the first maximum", per="sensor",
            attribute="first_maximum_time",
        ),
        Quantity(
            "sensor_largest_so_far", "", "largest force in the sensor in the run",
            unit="N", scale="force", label="largest force so far", per="sensor",
            attribute="largest_so_far",
        ),
        Quantity(
            "sensor_largest_so_far_time", "", "time of the largest force in the sensor",
            unit="s", scale="time", label="time of the largest force", per="sensor",
            attribute="largest_so_far_time",
        ),
        Quantity(
            "sensor_impulse", "", "time integral of the force in the sensor in the whole run",
            unit="N s", scale="momentum", label="impulse in the sensor", per="sensor",
            values="finite",
        ),
    )
)  # fmt: skip

# The state at the end of a run, which `simulate_many` gives.
FINAL_QUANTITIES: Final = _by_name(
    (
        Quantity(
            "final_position", "x", "displacement of the bead at the end of the run",
            unit="m", scale="length", label="displacement $x_k$ at the end", values="finite",
        ),
        Quantity(
            "final_velocity", "v", "velocity of the bead at the end of the run",
            unit="m/s", scale="velocity", label="velocity $v_k$ at the end", values="finite",
        ),
        Quantity(
            "end_time", "t", "time at the end of the run",
            unit="s", scale="time", label="time at the end", per="run",
        ),
        *(
            Quantity(
                name, "", f"fraction of the energy {where}",
                unit="1", scale="1", label="fraction of the energy", per="run", values="finite",
            )
            for name, where in (
                ("energy_forward", "in beads that move towards bead N"),
                ("energy_backward", "in beads that move away from bead N"),
                ("energy_in_contacts", "that contacts of two beads store"),
                ("energy_in_walls", "that contacts with walls store"),
                ("energy_lost", "that contacts have lost"),
            )
        ),
    )
)  # fmt: skip

# The largest values in the whole run, which `simulate_many` gives.
LARGEST_QUANTITIES: Final = _by_name(
    (
        Quantity(
            "largest_overlap", "d", "largest overlap of the contact in the whole run",
            unit="m", scale="length", label="largest overlap $d_k$", per="contact", values="finite",
        ),
        Quantity(
            "dent", "d_p", "residual overlap at which the contact opens after the whole run",
            unit="m", scale="length", label="dent $d_{p,k}$", per="contact", values="finite",
        ),
        Quantity(
            "yield_ratio", "",
            "largest pressure of all contacts in the whole run over that at first yield",
            unit="1", scale="1", label="pressure / pressure at first yield", per="run",
            values="finite",
        ),
    )
)  # fmt: skip

# Quantities that a run saves at each time.
RUN_QUANTITIES: Final = _by_name(
    (
        Quantity(
            "position", "x", "displacement of the bead",
            unit="m", scale="length", label="displacement $x_k(t)$", values="finite",
        ),
        Quantity(
            "velocity", "v", "velocity of the bead",
            unit="m/s", scale="velocity", label="velocity $v_k(t)$", values="finite",
        ),
        Quantity(
            "force", "F", "force in the contact",
            unit="N", scale="force", label="force $F_k(t)$", per="contact", values="finite",
        ),
    )
)  # fmt: skip

# Columns of a table of waves that have a unit.
WAVE_QUANTITIES: Final = _by_name(
    (
        Quantity("first_time", "", "time at its first contact", unit="s", scale="time", per="wave"),
        Quantity("last_time", "", "time at its last contact", unit="s", scale="time", per="wave"),
        Quantity("amplitude", "F", "largest force", unit="N", scale="force", per="wave"),
        Quantity("momentum", "P", "momentum", unit="N s", scale="momentum", per="wave"),
        Quantity("energy", "E", "energy", unit="J", scale="energy", per="wave"),
        Quantity("width", "", "duration of half the force", unit="s", scale="time", per="wave"),
        Quantity("speed", "V", "speed", unit="m/s", scale="radius/time", per="wave"),
    )
)  # fmt: skip

# Properties of the beads, and times, in datasets of pulses and runs.
BEAD_QUANTITIES: Final = _by_name(
    (
        Quantity("radius", "R", "radius", unit="m", scale="radius", label="radius $R_k$"),
        Quantity("mass", "m", "mass", unit="kg", scale="mass", label="mass $m_k$"),
    )
)
TIME: Final = Quantity("time", "t", "time", unit="s", scale="time", label="time $t$")
