"""HTML representations of waves, reflections, fronts, leading pulses, fluxes and states."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array
from ..simulation.energy_balance import EnergyBalance
from ..simulation.energy_flux import EnergyFlux
from ..simulation.fronts import Fronts
from ..simulation.leading_pulse import LeadingPulse
from ..simulation.reflection import Reflection
from ..simulation.state import LAST_STEP, State
from ..simulation.velocity_peaks import VelocityPeaks
from ..simulation.waves import DIRECTIONS, Wave, Waves
from .drawing import (
    COLOURS,
    Curve,
    axis_unit,
    chart,
    engineering,
    legend,
    note,
    numbers,
    page,
    sentence,
    table,
)

# Strongest waves that are drawn and listed, and strongest peaks that are listed.
MAX_WAVES: Final = 12


def waves_html(waves: Waves) -> str:
    """Tracks of the strongest waves, solid blue to the right and orange to the left, in a table."""
    units = waves.chain.units
    count = f"{len(waves.right)} right, {len(waves.left)} left"
    description = f"{waves.chain.description}: {count}"
    if not len(waves):
        parts = ["There are no waves.", sentence(waves._unlisted) if waves._unlisted else ""]
        return page("Waves", description, *(note(part) for part in parts if part))
    strongest = sorted(waves, key=lambda wave: -wave.energy)[:MAX_WAVES]
    shown = [wave for wave in waves if wave in strongest]
    slow, second = axis_unit(np.concatenate([wave.times for wave in shown]), "s", units)
    curves = []
    for wave in shown:
        order = np.argsort(wave.times)
        colour = COLOURS[0 if wave.direction > 0 else 1]
        contacts = np.asarray(wave.contacts, float)[order]
        curves.append(Curve(slow * wave.times[order], contacts, colour=colour))
    columns = {
        name: axis_unit(np.array([getattr(wave, name) for wave in shown]), unit, units)
        for name, unit in (("amplitude", "N"), ("momentum", "N s"), ("energy", "J"))
    }
    rows = [
        [
            "right" if wave.direction > 0 else "left",
            f"{wave.contacts.min()} to {wave.contacts.max()}",
            f"{slow * wave.times.min():.4g} to {slow * wave.times.max():.4g}",
            *(
                " to ".join(f"{factor * each:.4g}" for each in wave._along(name))
                for name, (factor, _) in columns.items()
            ),
        ]
        for wave in shown
    ]
    heads = [f"{name.replace('amplitude', 'force')}{unit}" for name, (_, unit) in columns.items()]
    parts = [
        legend((("to the right", COLOURS[0]), ("to the left", COLOURS[1]))),
        chart(curves, f"time{second}", "contact"),
        table(("direction", "contacts", f"time{second}", *heads), rows),
    ]
    if len(waves) > len(shown):
        parts.append(note(f"The {len(shown)} waves of the largest energy, of {len(waves)}."))
    if waves._unlisted:
        parts.append(note(sentence(waves._unlisted)))
    return page("Waves", description, *parts)


def wave_html(wave: Wave) -> str:
    """Largest force of a wave at each contact, and its numbers."""
    units, order = wave.chain.units, np.argsort(wave.contacts)
    factor, newton = axis_unit(wave.amplitudes, "N", units)
    curve = Curve(wave.contacts[order].astype(float), factor * wave.amplitudes[order])
    begin, end = (engineering(wave.times[i], "s", units) for i in (0, -1))
    found = {
        "contacts": f"{wave.contacts.min()} to {wave.contacts.max()}",
        "time": f"{begin} to {end}",
    }
    for word, name, unit in (
        ("force", "amplitude", "N"), ("momentum", "momentum", "N s"), ("energy", "energy", "J"),
        ("width in time", "width", "s"),
    ):  # fmt: skip
        if np.isfinite(getattr(wave, name)):
            found[word] = " to ".join(engineering(each, unit, units) for each in wave._along(name))
    parts = [chart([curve], "contact", f"largest force{newton}", whole=True), numbers(found)]
    if wave.merged:
        parts.append(note("Momentum and energy may include waves that have not separated."))
    if not wave.resolved:
        few = f"{wave.samples:.2g} saved times during the passage of a contact"
        parts.append(note(f"The wave is not resolved, with {few}: save more times."))
    about = f"to the {DIRECTIONS[wave.direction]}: {wave.chain.description}"
    return page("Wave", about, *parts)


def reflection_html(found: Reflection) -> str:
    """The incident wave, and the reflected and transmitted parts of it."""
    units, incident = found.chain.units, found.incident
    rows = [
        (
            name,
            f"{len(events)}",
            found._energy_in_words(name),
            found._momentum_in_words(name),
            f"{force:.4f}",
        )
        for name, events, force in (
            ("reflected", found.reflected, found.reflected_force),
            ("transmitted", found.transmitted, found.transmitted_force),
        )
    ]
    shown = {
        "incident wave at": engineering(incident.time, "s", units),
        "its energy": engineering(incident.energy, "J", units),
        "its momentum": engineering(incident.impulse, "N s", units),
        "its force": engineering(incident.amplitude, "N", units),
        "counted until": engineering(found.until, "s", units),
        f"momentum kept{', wall included' * found._wall}": f"{found.kept_momentum:.4f}",
        "energy kept": f"{found.kept_energy:.4f}",
    }
    if found._separated:
        shown["of this, in separated beads"] = f"{found.separated_energy:.4f}"
    if found._unexplained:
        shown["energy unexplained"] = f"{found.unexplained_energy:.4f}"
    parts = [
        table(("", "waves", "energy", "momentum", "largest force"), rows, numeric=True),
        numbers(shown), note("Parts are relative to the incident wave."),
    ]  # fmt: skip
    if late := [part for part in found._momenta if found._coming(part)]:
        parts.append(note(
            f"The {' and the '.join(late)} momentum {'is' if len(late) == 1 else 'are'} not "
            "complete: slow beads still carry momentum towards the contacts."
        ))  # fmt: skip
    if found.overlapping:
        parts.append(note(sentence(found._overlap)))
    if found.disturbed:
        parts.append(note("The count ended because another wave entered."))
    about = f"between contacts {found.before} and {found.after}: {found.chain.description}"
    return page("Reflection", about, *parts)


def velocity_peaks_html(peaks: VelocityPeaks) -> str:
    """Times, heights and widths of the largest peaks."""
    largest = np.sort(np.argsort(-peaks.amplitudes)[:MAX_WAVES])
    rows = [
        (engineering(peaks.times[i], "s", peaks.units),
         engineering(peaks.velocities[i], "m/s", peaks.units),
         engineering(peaks.widths[i], "s", peaks.units) if np.isfinite(peaks.widths[i]) else "")
        for i in largest
    ]  # fmt: skip
    parts = [table(("time", "velocity", "width"), rows)]
    if len(rows) < len(peaks):
        parts.append(note(f"The {len(rows)} largest of {len(peaks)} peaks."))
    return page("VelocityPeaks", f"of bead {peaks.bead}", *parts)


def energy_flux_html(flux: EnergyFlux) -> str:
    """Energy that passed each contact in both directions."""
    factor, joule = axis_unit(np.concatenate([flux.right, flux.left]), "J", flux.chain.units)
    contacts = np.arange(1.0, flux.chain.beads)
    curves = [
        Curve(contacts, factor * flux.right, "to the right", COLOURS[0]),
        Curve(contacts, factor * flux.left, "to the left", COLOURS[1]),
    ]
    return page(
        "EnergyFlux", flux.chain.description,
        legend((curve.label, curve.colour) for curve in curves),
        chart(curves, "contact", f"energy{joule}", whole=True),
    )  # fmt: skip


def energy_balance_html(balance: EnergyBalance) -> str:
    """Parts of the energy that passed a contact."""
    low, high = balance.nearby_energy
    shown = {
        "incident energy": engineering(balance.incident_energy, "J", balance.chain.units),
        "returned": f"{balance.returned_energy:.4f}",
        "at neighbouring contacts": f"{low:.4f} to {high:.4f}",
        "passed": f"{balance.passed_energy:.4f}",
        "kept": f"{balance.kept_energy:.4f}",
    }
    about = f"between contacts {balance.before} and {balance.after}: {balance.chain.description}"
    return page("EnergyBalance", about, numbers(shown),
                note("Parts are relative to the incident energy."))  # fmt: skip


def fronts_html(fronts: Fronts) -> str:
    """Time of the front at each contact, and its height at the first and last known contact."""
    units = fronts.chain.units
    figure = _per_contact(fronts.times, "s", "time", units)
    known = np.flatnonzero(np.isfinite(fronts.times))
    found = {"contacts": f"{len(known)} of {len(fronts.times)}"}
    for k in known[[0, -1]] if len(known) else []:
        found[f"at contact {k + 1}"] = engineering(float(fronts.times[k]), "s", units)
        found[f"height at {k + 1}"] = engineering(float(fronts.heights[k]), "N", units)
    return page("Fronts", fronts.chain.description, figure, numbers(found), *_notes(fronts.notes))


def leading_pulse_html(pulse: LeadingPulse) -> str:
    """Momentum of the leading pulse along the chain, and its last known values."""
    units = pulse.chain.units
    figure = _per_contact(pulse.momentum, "N s", "momentum", units)
    known = np.flatnonzero(np.isfinite(pulse.momentum))
    found = {"contacts": f"{len(known)} of {len(pulse.crest)}"}
    if len(known):
        k = int(known[-1])
        found |= {
            f"crest at contact {k + 1}": engineering(float(pulse.crest[k]), "s", units),
            "momentum": engineering(float(pulse.momentum[k]), "N s", units),
            "kinetic energy": engineering(float(pulse.kinetic_energy[k]), "J", units),
        }
    return page(
        "LeadingPulse", pulse.chain.description, figure, numbers(found), *_notes(pulse.notes)
    )


def state_html(state: State) -> str:
    """Velocities of all beads at the time of a state."""
    units = state.chain.units
    fast, speed = axis_unit(state.velocities, "m/s", units)
    curve = Curve(np.arange(1.0, state.chain.beads + 1.0), fast * state.velocities)
    fastest = int(np.argmax(np.abs(state.velocities)))
    found = {
        "time": engineering(state.time, "s", units),
        "fastest bead": f"{fastest + 1}",
        "its velocity": engineering(float(state.velocities[fastest]), "m/s", units),
    }
    figure = chart([curve], "bead", f"velocity{speed}", whole=True)
    notes = [note(sentence(LAST_STEP))] if state.time > 0.0 else []
    return page("State", state.chain.description, figure, numbers(found), *notes)


def _per_contact(values: Array, unit: str, name: str, units: str) -> str:
    factor, shown = axis_unit(values, unit, units)
    contacts = np.arange(1.0, len(values) + 1.0)
    return chart([Curve(contacts, factor * values)], "contact", f"{name}{shown}", whole=True)


def _notes(notes: object) -> list[str]:
    reasons = dict.fromkeys(notes.values()) if isinstance(notes, dict) else {}
    return [note(sentence(reason)) for reason in reasons if reason]
