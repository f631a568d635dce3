"""Measures of a design by name: quantities of the simulated motion, and of the chain itself.

======================================================  ===========================================
name                                                    meaning
======================================================  ===========================================
``wall_force.peak``, ``.duration``                      force on the right wall
``wall_force.impulse_of_impact``                        impulse of the impact on the right wall
``wall_force.largest_so_far``                           largest force on the right wall in the run,
                                                        which a later one may exceed
``body_force.peak``, ``.acceleration``, ``.duration``   largest force on the last body of a free
                                                        right end, such as an instrument, its
                                                        acceleration, and the time for which it
                                                        exceeds a tenth of the largest
``sensor.largest@k``                                    largest force in a sensor in bead k in the
                                                        run
``sensor.first_maximum@k``                              its first maximum
``velocity@k``, ``momentum@k``, ``energy@k``,           leading pulse at bead k, or ``@last``
``arrival@k``, ``residence@k``, ``peak_force@k``
``largest_velocity@k``, ``largest_momentum@k``,         at the largest forward velocity of bead k in
``largest_energy@k``                                    the whole run
``energy_share@k``, ``momentum_share@k``                of the impact's energy or momentum
``largest_force``                                       of all contacts and walls in the whole run
``yield_ratio``, ``overlap_ratio``                      largest of `hertzchain.HertzRange` in the
                                                        whole run
``length``, ``mass``, ``beads``, ``smallest_radius``,   of the beads without strikers and a cap
``largest_radius``
``price``                                               of the balls that vary
``velocity@100/velocity@20``, ...                       ratio of two measures of the leading pulse
======================================================  ===========================================
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from ..chain.bead_names import CAP, NAME, bead_number
from ..chain.chain import Chain
from ..chain.hertz_range import UNKNOWN_YIELD, hertz_range
from ..collision import Array
from ..derivatives.equation import has_gradient
from ..errors import InputError, short_repr, similar_names, unknown_name_error
from ..pulse.pulse import Pulse
from ..pulse.quantities import BODY_QUANTITIES, QUANTITIES, WALL_QUANTITIES
from ..pulse.quantity_names import COLUMNS, full_name
from ..representation import measure as shown
from ..simulation.body_peak import not_on_a_wall
from ..simulation.run_table import RunTable
from ..simulation.sensor_force import HALF, free_face_note
from ..simulation.wall_bound import LATER_IMPACTS, RIGHT, motion_can_escape
from ..validation.numbers import whole_number

LARGEST_ON_WALL: Final = "wall_force.largest_so_far"
IMPULSE: Final = "wall_force.impulse_of_impact"
# Columns of a `RunTable` with the force on the wall; the impulse is that of the impact.
WALL: Final = {
    **{name: COLUMNS[name] for name in ("wall_force.peak", "wall_force.duration", LARGEST_ON_WALL)},
    IMPULSE: COLUMNS[IMPULSE],
}
BODY_PEAK: Final = "body_force.peak"
# All quantities of the last body except the time of its largest force.
BODY: Final = {
    full_name(name): name for name in BODY_QUANTITIES if not name.endswith("_time")
}  # fmt: skip
# Of the whole chain and of a run: each has a column with one value per chain.
ENDS: Final = WALL | BODY
PULSE: Final = ("velocity", "momentum", "energy", "arrival", "residence", "peak_force")
FIRST_MAXIMUM, LARGEST_IN_SENSOR = "sensor.first_maximum", "sensor.largest"
SENSORS: Final = (LARGEST_IN_SENSOR, FIRST_MAXIMUM)
LARGEST: Final = ("largest_velocity", "largest_momentum", "largest_energy")
SHARES: Final = {"energy_share": "energy", "momentum_share": "momentum"}
RANGE: Final[tuple[str, ...]] = ("yield_ratio", "overlap_ratio")
OF_CHAIN: Final = {
    "length": "m", "mass": "kg", "beads": "1", "price": "1",
    "smallest_radius": "m", "largest_radius": "m",
}  # fmt: skip
CURVES: Final = (*PULSE, *SHARES, *LARGEST)
AT_BEAD: Final = (*CURVES, *SENSORS)
# Names of columns, and of an attribute of `SensorForce`, which are accepted, too.
BY_COLUMN: Final = (
    {column: name for name, column in ENDS.items()}
    | {COLUMNS[name]: name for name in SENSORS}
    | {"sensor.largest_so_far": LARGEST_IN_SENSOR}
)
WORDS: Final = {
    "wall_force.peak": "peak force on the wall",
    IMPULSE: "impulse on the wall",
    "wall_force.duration": "impulse / peak of the force on the wall",
    LARGEST_ON_WALL: "largest force on the wall in the run",
    **{name: BODY_QUANTITIES[column].label for name, column in BODY.items()},
    "largest_force": "largest force", LARGEST_IN_SENSOR: "largest force in the sensor",
    FIRST_MAXIMUM: "first maximum of the force in the sensor",
    "yield_ratio": "pressure / pressure at first yield", "overlap_ratio": "overlap / radius",
    "length": "length of the chain", "mass": "mass of the chain", "beads": "number of beads",
}  # fmt: skip
# Units of lengths and masses of chains in summaries.
USUAL: Final = {"m": (1e3, "mm"), "kg": (1e3, "g")}
NAMES: Final = (*ENDS, *AT_BEAD, "largest_force", *RANGE, *OF_CHAIN)


@dataclass(frozen=True)
class Measure:
    """A quantity of a chain and its motion.

    ``bead`` is 0 for the last one; ``name`` is that by which the user gave it, such as ``ball 4``.
    """

    key: str
    bead: int | None = None
    over: Measure | None = None
    name: str = field(default="", repr=False)

    def __str__(self) -> str:
        own = self.key if self.bead is None else f"{self.key}@{self.name or self.bead or 'last'}"
        return own if self.over is None else f"{own}/{self.over}"

    @property
    def label(self) -> str:
        """Description in words, for axes: ``peak force on the wall``, ``velocity of bead 20``."""
        own = WORDS.get(self.key, self.key.replace("_", " "))
        if self.bead is not None:
            named = self.name or f"bead {self.bead}"
            own += f" of {named}" if self.bead else " of the last bead"
        return own if self.over is None else f"{own} / {self.over.label}"

    @property
    def of_chain(self) -> bool:
        """Whether it needs no simulation."""
        return self.key in OF_CHAIN

    @property
    def quantity(self) -> str:
        """Name in the table of quantities, of a measure at a bead."""
        return SHARES.get(self.key, self.key).removeprefix("largest_")

    @property
    def unit(self) -> str:
        """Unit of a chain in SI units; ``"1"`` if it has none."""
        if self.over is not None:
            return "1"
        if self.key in WALL:
            return WALL_QUANTITIES[WALL[self.key]].unit
        if self.key in BODY:
            return BODY_QUANTITIES[BODY[self.key]].unit
        if self.key in (*PULSE, *LARGEST):
            return QUANTITIES[self.quantity].unit
        return "N" if self.key in ("largest_force", *SENSORS) else OF_CHAIN.get(self.key, "1")

    @property
    def has_kinks(self) -> bool:
        """Whether its derivatives jump, because it is the largest of several peaks."""
        kinks = ("wall_force.peak", "wall_force.duration", LARGEST_ON_WALL, *BODY)
        return self.key in (*kinks, "largest_force", LARGEST_IN_SENSOR, *RANGE, *LARGEST)

    @property
    def of_whole_run(self) -> bool:
        """Whether it is read from the integration of `hertzchain.gradient`."""
        return self.key in LARGEST

    def ends(self, chain: Chain) -> bool:
        """Whether it is complete at the end of a run without stop time."""
        returns = chain.right_wall is not None or chain.precompression > 0.0 or chain.gravity
        return not (self.of_whole_run and returns)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of a `RunTable` from which it is computed."""
        if self.over is not None:
            return (*self._numerator.columns, *self.over.columns)
        if self.key in ENDS:
            return (ENDS[self.key],)
        if self.key in SENSORS:
            return (COLUMNS[self.key],)
        if self.of_whole_run:
            return ()
        if self.key in AT_BEAD:
            return (self.quantity,)
        return () if self.of_chain else ("largest_overlap",)

    @property
    def _numerator(self) -> Measure:
        return Measure(self.key, self.bead)

    def index(self, beads: int) -> int:
        """Index in an array of a chain with this number of beads."""
        return (self.bead or self._count(beads)) - 1

    def _count(self, beads: int) -> int:
        return beads if self.key in SENSORS else QUANTITIES[self.quantity].count(beads)

    def check(self, chain: Chain) -> None:
        """Raise `InputError` if a chain does not have the measure."""
        if self.over is not None:
            self.over.check(chain)
        if self.key in WALL and chain.right_wall is None:
            raise InputError(
                f"{self} needs a right wall, and the right end of this chain is free: add one; "
                "the force on its last body is body_force.peak"
            )
        if self.key in BODY and chain.right_wall is not None:
            raise InputError(not_on_a_wall(str(self)))
        if self.bead is not None and self.index(chain.beads) >= self._count(chain.beads):
            raise InputError(f"{self}: this chain has {chain.beads} beads")
        if self.of_whole_run and not has_gradient(chain):
            raise InputError(
                f"{self} needs a chain without drive that is elastic or has the loss Viscoelastic, "
                "Restitution or Dashpot"
            )
        if self.key == "largest_force" and not chain.lossless:
            raise InputError(
                "largest_force is computed from the largest overlaps of elastic contacts, and this "
                "chain has losses; use wall_force.peak or peak_force@k"
            )
        if self.key in RANGE and (chain.units != "SI" or chain.materials is None):
            raise InputError(f"{self} needs a chain with materials; use Chain.from_materials")
        if self.key == "yield_ratio" and _all_yield(chain):
            raise InputError(
                "yield_ratio is the pressure of elastic contacts over that at first yield, and all "
                "contacts of this chain have a law with yield (ElasticPlastic): omit yield_ratio, "
                "or the loss"
            )
        if self.key == "yield_ratio" and np.isnan(hertz_range(chain).largest_yield_ratio):
            raise InputError(
                f"yield_ratio is unknown, because {UNKNOWN_YIELD}; "
                "omit it, or define materials with yield_strength"
            )

    def from_table(self, table: RunTable) -> Array:
        """Values of simulated chains, shape (C,); NaN if a run failed."""
        if self.over is not None:
            return self._numerator.from_table(table) / self.over.from_table(table)
        if self.key in ENDS:
            return np.array(table[self.columns[0]])
        if self.key in SENSORS:
            bead = self.index(int(table.beads.max(initial=2))) + 1
            return np.array(table[self.columns[0]][:, table.sensors.index(bead)])
        if self.key in AT_BEAD:
            column, counts = table[self.columns[0]], table.beads
            rows = np.arange(len(table))
            places = np.array([self.index(max(int(count), 2)) for count in counts])
            inside = places < column.shape[1]
            values = np.where(inside, column[rows, np.minimum(places, column.shape[1] - 1)], np.nan)
            return values / self._units_of_share(table.chains)
        return np.array([self._worst(table, i) for i in range(len(table))])

    def from_pulse(self, pulse: Pulse) -> float:
        """Value of a leading pulse, as given by a theory."""
        if self.over is not None:
            return self._numerator.from_pulse(pulse) / self.over.from_pulse(pulse)
        values = pulse.column(self.columns[0])
        assert values is not None
        place = self.index(pulse.chain.beads)
        return float(values[place] / np.max(self._units_of_share([pulse.chain])))

    def _units_of_share(self, chains: Sequence[Chain | None]) -> Any:
        if self.key not in SHARES:
            return 1.0
        power = 2 if self.key == "energy_share" else 1
        half = 0.5 if power == 2 else 1.0
        return np.array(
            [np.nan if c is None else half * float(c.masses @ np.abs(c.velocities) ** power)
             for c in chains]
        )  # fmt: skip

    def _worst(self, table: RunTable, i: int) -> float:
        chain = table.chains[i]
        if chain is None or i in table.reasons:
            return float("nan")
        overlaps = table._overlaps[i, : chain.beads + 1]
        if self.key == "largest_force":
            return float(np.max(chain.contact_stiffness * overlaps**chain.contact_exponents))
        limits = hertz_range(chain, overlaps)
        return float(
            limits.largest_yield_ratio
            if self.key == "yield_ratio"
            else np.nan_to_num(limits.overlap_ratio).max()
        )

    def from_chain(self, chain: Chain, price: float) -> float:
        """Value of a measure that needs no simulation, without strikers and a cap."""
        balls, between = chain._balls, places_of_balls(chain, "gaps")
        radii, masses = chain.radii[balls], chain.masses[balls]
        values = {
            "length": 2.0 * radii.sum() + chain.gaps[between].sum(),
            "mass": masses.sum(), "beads": len(radii), "price": price,
            "smallest_radius": radii.min(), "largest_radius": radii.max(),
        }  # fmt: skip
        return float(values[self.key])

    def slope_of_chain(self, chain: Chain, field: str) -> Array:
        """Derivatives of a measure that needs no simulation, by a field of the chain."""
        found = np.zeros(len(getattr(chain, field)))
        balls = chain._balls
        own = found[places_of_balls(chain, field)]
        if self.key == "length" and field in ("radii", "gaps"):
            own += 2.0 if field == "radii" else 1.0
        elif self.key == "mass":
            if field == "masses":
                own += 1.0
            elif field == "radii" and "masses" not in chain.given:
                own += 3.0 * chain.masses[balls] / chain.radii[balls]
        elif field == "radii" and self.key in ("smallest_radius", "largest_radius"):
            radii = chain.radii[balls]
            own[radii.argmin() if self.key == "smallest_radius" else radii.argmax()] = 1.0
        return found


def without_in_words(chain: Chain) -> str:
    """Such as `` without the striker and the cap``, which sums over beads do not count."""
    strikers, cap = chain.strikers, chain.cap is not None
    bodies = [f"the striker{'s' * (strikers > 1)}"] * (strikers > 0) + ["the cap"] * cap
    return f" without {' and '.join(bodies)}" if bodies else ""


def places_of_balls(chain: Chain, field: str) -> slice:
    """Places of the balls, or of the gaps between them, among the values of a field.

    They are without those of strikers and of a cap.
    """
    balls = chain._balls
    return slice(balls.start, balls.stop - (field == "gaps"))


def _all_yield(chain: Chain) -> bool:
    """Whether the law of every contact describes its yield."""
    contacts = zip(chain.contact_losses, chain.contact_stiffness, strict=True)
    return all(law.yields for law, stiffness in contacts if stiffness > 0.0)


def sensors_of(measures: Iterable[Measure], chains: Iterable[Chain]) -> tuple[int, ...]:
    """Numbers of the beads with sensors that measures of these chains need."""
    beads = {chain.beads for chain in chains}
    numbers = {each.index(n) + 1 for each in measures if each.key in SENSORS for n in beads}
    return tuple(sorted(numbers))


def note_on_free_faces(chain: Chain, measures: Iterable[Measure]) -> str:
    """That sensors in beads at free ends have half of the force; empty without any."""
    sensors = {str(m): m.index(chain.beads) + 1 for m in measures if m.key in SENSORS}
    return free_face_note(chain, sensors)


def note_on_later_impacts(chain: Chain, measures: Iterable[Measure]) -> str:
    """That forces on the wall are those so far; empty if no later force can exceed them."""
    keys = {each.key for m in measures for each in (m, m.over) if each is not None}
    if not keys & (WALL.keys() - {LARGEST_ON_WALL}) or motion_can_escape(chain, RIGHT):
        return ""
    return f"the force on the wall is that so far: {LATER_IMPACTS}"


def notes_on(chain: Chain, measures: Iterable[Measure]) -> list[str]:
    """Notes on measures that have less than the whole force, or may be exceeded later."""
    listed = list(measures)
    notes = note_on_free_faces(chain, listed), note_on_later_impacts(chain, listed)
    return [note for note in notes if note]


def label_in(chain: Chain, measure: Measure) -> str:
    """Description of a measure of a chain, for axes."""
    return f"{measure.label} ({HALF})" if note_on_free_faces(chain, [measure]) else measure.label


def in_words(value: float, unit: str, units: str) -> str:
    """A value with its unit, lengths in mm and masses in g."""
    factor, usual = USUAL.get(unit, (1.0, unit)) if units == "SI" else (1.0, unit)
    return shown(factor * value, "" if usual == "1" else usual, units).strip()


def measure_of(chain: Chain, name: object) -> Measure:
    """The measure of a chain with this name, which may have the name of a ball."""
    measure = parse_measure(name, chain)
    measure.check(chain)
    return measure


def check_name(name: object, value: object) -> None:
    """Raise `InputError` for a table, which TOML makes of a name with a dot and no quotes."""
    if isinstance(value, Mapping) and value:
        (key, inner), *_ = value.items()
        shown = inner if isinstance(inner, float | int) else repr(inner).replace("'", '"')
        raise InputError(
            f"{name}.{key} needs quotes in a TOML file, because of the dot: write "
            f'"{name}.{key}" = {shown}'
        )


def unknown_quantities(names: Iterable[object]) -> Iterator[str]:
    """Describe by one sentence the names of no quantity, whose place after ``@`` may be wrong."""
    described = []
    for part in (part for name in names if isinstance(name, str) for part in name.split("/")):
        key = part.removeprefix("pulse.").partition("@")[0]
        if BY_COLUMN.get(key, key) not in NAMES:
            near = similar_names(part, NAMES)
            described.append(f"{part!r} (did you mean {near}?)" if near else repr(part))
    if described:
        noun = "quantities" if len(described) > 1 else "quantity"
        yield f"unknown {noun} {', '.join(described)}: choose from {', '.join(NAMES)}"


def parse_measure(text: object, chain: Chain | None = None) -> Measure:
    """Read a name such as ``velocity@90`` or, of a given chain, ``velocity@ball 9``."""
    if not isinstance(text, str):
        raise InputError(
            f"a measure must be a name, such as 'wall_force.peak', got {short_repr(text)}"
        )
    above, slash, below = text.partition("/")
    if slash:
        one, other = parse_measure(above, chain), parse_measure(below, chain)
        if not {one.key, other.key} <= {*PULSE, *SHARES}:
            raise InputError(
                f"both parts of the ratio {text!r} must be quantities of the leading pulse, as in "
                "'velocity@100/velocity@20'"
            )
        return Measure(one.key, one.bead, other, one.name)
    key, at, place = text.removeprefix("pulse.").partition("@")
    key = BY_COLUMN.get(key, key)
    if key not in NAMES:
        raise unknown_name_error("quantity", text, NAMES)
    if key not in AT_BEAD:
        if at:
            raise InputError(f"{key} does not belong to a bead: omit @{place}")
        return Measure(key)
    if not at:
        wall = "; that on a wall is wall_force.peak" if key == "peak_force" else ""
        raise InputError(f"{key} needs a bead: write {key}@20 or {key}@last{wall}")
    if place == "last":
        return Measure(key, 0)
    name = " ".join(place.lower().split())
    if chain is not None and (name == CAP or NAME.fullmatch(name)):
        return Measure(key, bead_number(chain, name), name=name)
    try:
        bead = int(place)
    except ValueError:
        wall = "; that on the wall is wall_force.peak" if place == "wall" else ""
        raise InputError(f"the bead of {text!r} must be a number or 'last'{wall}") from None
    return Measure(key, whole_number(f"bead of {text!r}", bead, least=1))
