"""Figures of the how-to guides on losses, odd beads, pads, and the errors of a force."""

import warnings
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from page_figures import chain_rows
from scipy.signal import find_peaks

import hertzchain as hc
from hertzchain.plotting.colours import COLOURS
from hertzchain.plotting.style import MARKERS, BeadLocator, figure_style, label_log_axis

# Laws with a restitution of 0.95 in two steel balls of 10 mm that meet at 0.3 m/s.
EQUIVALENT: Final = {
    "Restitution": hc.Restitution(0.95),
    "Viscoelastic": hc.Viscoelastic("0.3587 us"),
    "Dashpot": hc.Dashpot(4.839),
    "UnloadingRatio": hc.UnloadingRatio(0.0975),
    "WaltonBraun": hc.WaltonBraun(0.9025),
    "ElasticPlastic": hc.ElasticPlastic(yield_pressure="2.2492 GPa"),
}
# Those whose restitution does not depend on the speed.
INTERLEAVED: Final = ("Restitution", "UnloadingRatio", "WaltonBraun")


def losses() -> Figure:
    """Restitution of several laws, and the forces along a chain with these laws."""
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=20, velocity="0.3 m/s")
    chain = balls.replace(right_wall=hc.Wall())
    speeds, contact = np.geomspace(0.01, 1.0, 61), np.arange(1, 20)
    dashes = ("-", "--", ":", "-", "--", "-.")
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.7), layout="constrained")
        elastic = hc.simulate(chain).pulse().peak_force
        right.plot(contact, elastic[:19], color=COLOURS[0], linewidth=0.9, label="no loss")
        for i, (name, law) in enumerate(EQUIVALENT.items(), 1):
            e = [law.restitution(float(v), chain=chain, contact=1) for v in speeds]
            style = {"color": COLOURS[i], "linestyle": dashes[i - 1], "label": name}
            # Three laws have the same constant; their dashes follow each other.
            same = (
                {"linestyle": (4 * INTERLEAVED.index(name), (4, 8))} if name in INTERLEAVED else {}
            )
            left.semilogx(speeds, e, **style | same)
            force = hc.simulate(chain.replace(loss=law)).pulse().peak_force
            right.plot(contact, force[:19], **style)
        left.axvline(0.3, color="0.6", linewidth=0.8)
        # Far above yield, the restitution of ElasticPlastic is below those of all others.
        left.set_ylim(0.897, 1.004)
        left.set_xlabel("speed before the collision [m/s]")
        left.set_ylabel("coefficient of restitution")
        left.text(0.011, 0.952, "three laws coincide", color="0.3")
        right.set_ylim(25.0, None)
        right.set_xticks([1, 5, 10, 15, 19])
        right.set_xlabel("contact $k$")
        right.set_ylabel("largest force\nwithout damping [N]")
        handles, labels = right.get_legend_handles_labels()
        canvas.legend(handles, labels, loc="outside lower center", ncols=4)
    return canvas


def defect_chains() -> Figure:
    """Chains with a different bead, a step, a gap, and small beads between large ones."""
    row = hc.Chain.uniform(12)
    return chain_rows(
        {
            "Chain.uniform(12).with_defects({6: 1.6})": row.with_defects({6: 1.6}),
            "Chain.uniform(12).with_defects({6: 0.5})": row.with_defects({6: 0.5}),
            "Chain.from_radii(np.where(np.arange(12) < 6, 1.0, 0.5))":
                hc.Chain.from_radii(np.where(np.arange(12) < 6, 1.0, 0.5)),
            "Chain.uniform(9).decorated(0.3)": hc.Chain.uniform(9).decorated(0.3),
            "Chain.dimer(radii=[1.0, 0.7], beads=12)": hc.Chain.dimer(radii=[1.0, 0.7], beads=12),
        },
        5.4,
    )  # fmt: skip


def defects() -> Figure:
    """Forces in chains with a heavy bead, a light bead, and steps to larger and smaller beads."""
    row, bead = hc.Chain.uniform(80), np.arange(80)
    chains = {
        "a bead of radius 2": row.with_defects({40: 2.0}),
        "a bead of radius 0.5": row.with_defects({40: 0.5}),
        "second half of radius 2": hc.Chain.from_radii(np.where(bead < 40, 1.0, 2.0)),
        "second half of radius 0.5": hc.Chain.from_radii(np.where(bead < 40, 1.0, 0.5)),
    }
    with figure_style():
        canvas, panels = plt.subplots(2, 2, figsize=(6.9, 5.6), sharex=True, layout="constrained")
        for axes, (title, chain) in zip(panels.flat, chains.items(), strict=True):
            hc.simulate(chain, until=85.0, times=1600).plot("force", ax=axes)
            axes.set_title(title)
        for axes in panels[0]:
            axes.set_xlabel("")
    return canvas


def rattling() -> Figure:
    """Force on a light bead while the pulse passes, and its motion relative to its neighbours."""
    run = hc.simulate(hc.Chain.uniform(100).with_defects({50: 0.2}), until=66.0, times=16501)
    velocity = run.velocity(50) - 0.5 * (run.velocity(49) + run.velocity(51))
    with figure_style():
        canvas, (upper, lower) = plt.subplots(2, 1, figsize=(6.6, 4.4), sharex=True)
        for contact, dashes in ((49, "-"), (50, "--")):
            upper.plot(run.times, run.force(contact), dashes, color=COLOURS[contact - 48],
                       label=f"contact {contact}")  # fmt: skip
        upper.set_ylabel("force")
        upper.legend()
        lower.plot(run.times, velocity, color=COLOURS[0])
        lower.set_ylabel("velocity relative\nto the neighbours")
        lower.set_xlabel("time $t$")
        lower.set_xlim(55.0, 65.0)
        lower.set_ylim(-0.03, 0.03)
    return canvas


def _reflected(radius: float) -> float:
    """Reflected fraction of the energy at a step from radius 1 to another one."""
    chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, radius))
    return hc.simulate(chain, until=150.0, times=3000).reflection(50, 72).reflected_energy


def interfaces() -> Figure:
    """Reflected energy at steps, and the train beyond a step to smaller beads."""
    radii = np.array([1.0, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.3, 2.7])
    fine = np.linspace(1.0, 2.8, 91)
    chain = hc.Chain.from_radii(np.where(np.arange(160) < 60, 1.0, 0.5))
    train = hc.simulate(chain, until=150.0, times=4000).waves().passing(120)
    force = np.array([wave.to_dataframe().amplitude[120] for wave in train][:7])
    number = np.arange(1, len(force) + 1)
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2))
        left.plot(fine, ((fine**3 - 1) / (fine**3 + 1)) ** 2, color=COLOURS[1],
                  label="independent collisions")  # fmt: skip
        left.plot(radii, [_reflected(radius) for radius in radii], MARKERS[0], color=COLOURS[2],
                  label="simulation")  # fmt: skip
        left.set_xlabel("radius of the second half")
        left.set_ylabel("reflected fraction of the energy")
        left.legend(loc="lower right")
        ratio = ((8.0 - 1.0) / (8.0 + 1.0)) ** 1.2
        right.semilogy(number, ratio ** (number - 1.0), color=COLOURS[1])
        right.semilogy(number, force / force[0], MARKERS[0], color=COLOURS[2])
        right.set_xlabel("wave of the train, radius 0.5")
        right.set_ylabel("force / force of the first wave")
    return canvas


def impurities() -> Figure:
    """Energy reflected by one bead of another mass, with equal contacts."""
    ratios, fine = np.geomspace(0.05, 30.0, 25), np.geomspace(0.04, 40.0, 400)
    row, reflected = hc.Chain.uniform(120), []
    for ratio in ratios:
        masses = row.masses.copy()
        masses[59] = ratio
        run = hc.simulate(row.replace(masses=masses), until=170.0, times=1500)
        with warnings.catch_warnings():
            # Heavy beads pass their energy on slowly, which does not change what they reflect.
            warnings.filterwarnings("ignore", message="the transmitted energy")
            reflected.append(run.reflection(48, 72).reflected_energy)
    with figure_style():
        canvas, axes = plt.subplots(figsize=(5.6, 3.2))
        axes.loglog(fine, ((fine - 1.0) / (fine + 1.0)) ** 2, color=COLOURS[1],
                    label="independent collisions")  # fmt: skip
        axes.loglog(ratios, reflected, MARKERS[0], color=COLOURS[2], label="simulation")
        axes.set_ylim(2e-4, 1.5)
        axes.set_xlabel("mass ratio $\\mu$")
        axes.set_ylabel("reflected fraction of the energy")
        axes.legend(loc="lower right")
    return canvas


def gaps() -> Figure:
    """Velocity of the pulse beyond a gap, and its delay."""
    row = hc.Chain.uniform(100)
    same, widths = hc.propagate(row), np.linspace(0.0, 3.0, 25)
    kept, delay = [], []
    for width in widths:
        gap = np.zeros(99)
        gap[49] = width
        pulse = hc.simulate(row.replace(gaps=gap), times=0).pulse()
        kept.append(pulse.velocity[79] / same.velocity[79])
        delay.append(pulse.peak_time[79] - same.peak_time[79])
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.0))
        left.plot(widths, kept, "o-", color=COLOURS[1], markersize=3.5, label="simulation")
        left.axhline(0.98567886, color=COLOURS[2], linestyle="--", linewidth=1.0,
                     label="limit of a wide gap")  # fmt: skip
        left.legend(loc="upper right")
        left.set_ylabel("velocity / velocity without gap")
        right.plot(widths, delay, "o-", color=COLOURS[1], markersize=3.5)
        right.plot(widths, widths / 0.98567886, "--", color=COLOURS[2], linewidth=1.0)
        right.set_ylabel("delay")
        for axes in (left, right):
            axes.set_xlabel("width of the gap")
    return canvas


def dimer_pulses() -> Figure:
    """Time between large beads with small ones between them, and pulses along dimers."""
    radii, equal = np.linspace(0.1, 0.6, 11), hc.propagate(hc.Chain.uniform(60))
    pulses = hc.propagate_many([hc.Chain.uniform(60).decorated(radius) for radius in radii])
    times = (pulses.peak_time[:, 80] - pulses.peak_time[:, 40]) / (
        equal.peak_time[40] - equal.peak_time[20]
    )
    fine = np.linspace(0.1, 0.6, 101)
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2))
        series = ((1.0 + fine**3) * 2.0**1.5 / np.sqrt(2.0 * fine / (1.0 + fine))) ** 0.4
        left.plot(radii, times, MARKERS[0], color=COLOURS[2], label="simulation")
        left.plot(fine, series, color=COLOURS[1], label="formula")
        left.legend(loc="upper right")
        left.set_xlabel("radius of the small beads")
        left.set_ylabel("time / time without them")
        for i, ratio in enumerate((0.342845, 0.2397, 0.58)):
            velocity = hc.propagate(hc.Chain.dimer(ratio, beads=101)).velocity[:82:2]
            right.plot(2 * np.arange(41) + 1, velocity, MARKERS[i], color=COLOURS[i + 1],
                       markersize=3.5, label=f"mass ratio {ratio:.4g}")  # fmt: skip
        right.set_ylim(0.0, None)
        right.set_xlabel("bead $k$, heavy beads only")
        right.xaxis.set_major_locator(BeadLocator())
        right.set_ylabel("velocity $v_k$")
        right.legend(loc="lower left")
    return canvas


def certainty() -> Figure:
    """Force behind a row of steel and PTFE, elastic and with contacts that yield."""
    kinds = ["steel-52100"] * 5 + ["ptfe"] * 5 + ["steel-52100"] * 5
    cell = hc.Wall("5 kN/mm", exponent=1, loss=hc.Elastic())
    balls = hc.Chain.from_materials(np.linspace(6e-3, 3e-3, 15), kinds, right_wall=cell)
    elastic = balls.struck_by(mass="30 g", velocity="0.5 m/s")
    pressures = np.linspace(1.6, 2.8, 49)
    chains = [elastic.replace(loss=hc.ElasticPlastic(factor=each)) for each in pressures]
    shown = {"elastic": elastic, "yield at 1.6 $Y$": chains[0], "yield at 2.8 $Y$": chains[-1]}
    with figure_style(), warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        canvas, panels = plt.subplot_mosaic(
            [[label, "largest"] for label in shown], figsize=(7.4, 4.2), layout="constrained",
            height_ratios=[9, 5, 5],
        )  # fmt: skip
        right = panels.pop("largest")
        for i, (label, axes) in enumerate(panels.items()):
            run = hc.simulate(shown[label], until="3 ms", times=6001)
            axes.plot(1e3 * run.times, run.sensor("wall"), color=COLOURS[1], linewidth=0.9)
            axes.set_title(label, y=0.8)
            axes.set_xlim(0.0, 3.0)
            # The heights of the panels give all forces the same scale.
            axes.set_ylim(0.0, 50.0 if i else 90.0)
            axes.set_yticks([0, 25, 50, 75][: 3 if i else 4])
            axes.tick_params(labelbottom=i == len(panels) - 1)
        runs = [hc.simulate(chain, until="1.2 ms", times=1201).sensor("wall") for chain in chains]
        first = [force[find_peaks(force, prominence=0.2 * force.max())[0][0]] for force in runs]
        table = hc.simulate_many(chains, keep=["wall_force.peak"])
        right.plot(pressures, table["wall_force.peak"], MARKERS[0], linestyle="-", linewidth=0.7,
                   color="0.5", label="whole run")  # fmt: skip
        right.plot(pressures, first, color="black", linewidth=1.6, label="first pulse")
        axes.set_xlabel("time [ms]")
        right.set_xlabel("yield pressure / yield strength $Y$")
        panels["yield at 1.6 $Y$"].set_ylabel("force on the load cell [N]")
        right.set_ylabel("largest force [N]")
        right.set_ylim(0.0, None)
        right.legend(loc="lower right")
    return canvas


def pads() -> Figure:
    """Force on a wall behind a pad, by its stiffness and over time."""
    balls = hc.Chain.from_materials(diameters="20 mm", materials="steel-52100", beads=10)
    row = balls.struck_by(velocity="0.4 m/s")
    mass = row.masses[-1]

    def behind(k: float) -> hc.Chain:
        return row.replace(right_wall=hc.Wall(k, exponent=1, loss=hc.Elastic()))

    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.3))
        k = np.geomspace(1e5, 1e8, 37)
        peaks = hc.simulate_many([*map(behind, k)], keep=["wall_force.peak"])["wall_force.peak"]
        hard = row.replace(right_wall=hc.Wall())
        left.loglog(1e-6 * k, peaks, label="simulation")
        left.loglog(1e-6 * k, 0.4 * np.sqrt(k * mass), "--", label=r"$v\sqrt{km}$")
        left.axhline(hc.simulate(hard).wall_force().peak, color="0.6", linewidth=0.8,
                     linestyle=":", label="without a pad")  # fmt: skip
        for axis in (left.xaxis, left.yaxis):
            label_log_axis(axis)
        left.set_xlabel("stiffness of the pad [kN/mm]")
        left.set_ylabel("largest force on the wall [N]")
        left.legend()
        # Discs of 20 mm with a modulus of 5 MPa.
        discs = {"2 mm": 10.6e6, "3 mm": 3.43e6, "5 mm": 0.942e6}
        rows = {"none": hard} | {name: behind(k) for name, k in discs.items()}
        for name, chain in rows.items():
            run = hc.simulate(chain, until="2 ms", times=4001)
            right.plot(1e3 * run.times, run.sensor("wall"), label=name)
        right.set_xlabel("time [ms]")
        right.set_ylabel("force on the wall [N]")
        right.legend(title="pad")
    return canvas


def localisation() -> Figure:
    """Decay of vibrations along disordered rows under a static force, and their modes."""
    equal = hc.Chain.from_materials("5 mm", "steel-52100", beads=300)
    equal = equal.replace(precompression="20 N", held_by="force")
    edge, scatter = hc.spectrum(equal).band_edges()[0, 1], 0.05
    shares, rows = np.arange(0.2, 0.96, 0.05), 20
    near = edge * np.add.outer(shares, np.linspace(-0.025, 0.025, 21)).ravel()
    decays = []
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1), layout="constrained")
        for seed in range(rows):
            row = equal.with_scatter(seed, relative=scatter)
            found = hc.spectrum(row)
            decay = -np.log(abs(found.transfer_force(near, contact=150))) / 150
            decays.append(decay.reshape(len(shares), -1).mean(axis=1))
            # Mode 0 is the translation of the whole row.
            energy = row.masses[:, None] * found.modes**2
            number = energy.sum(axis=0) ** 2 / (energy**2).sum(axis=0)
            right.plot(
                found.frequencies[1:] / edge, number[1:], ".", color=COLOURS[2], markersize=1.5,
                rasterized=True,
            )  # fmt: skip
        error = np.std(decays, axis=0) / rows**0.5
        left.errorbar(shares, np.mean(decays, axis=0), error, fmt=MARKERS[0], color=COLOURS[2],
                      markersize=4.0, label="20 rows")  # fmt: skip
        fine = np.linspace(0.15, 0.97, 200)
        springs = (3.0 + (1.0 - 2.0 * fine**2) / 3.0) ** 2
        theory = 0.5 * scatter**2 * fine**2 / (1.0 - fine**2) * springs
        left.plot(fine, theory, color=COLOURS[1], label="weak disorder")
        left.set_yscale("log")
        left.set_ylim(2e-4, 0.2)
        left.set_ylabel("decay per ball $\\gamma$")
        left.legend(loc="lower right")
        right.axhline(200.0, color="0.5", linewidth=0.8)
        right.set_ylim(0.0, None)
        right.set_ylabel("participation number of the mode")
        for axes in (left, right):
            axes.set_xlabel("frequency / edge of the band")
    return canvas


def light_bead() -> Figure:
    """Modes of a precompressed row with a light bead, and the localised one."""
    balls = hc.Chain.from_materials(diameters="19.05 mm", materials="steel-52100", beads=41)
    row = balls.with_defects(diameters={21: "10 mm"})
    found = hc.spectrum(row.replace(precompression="20 N", held_by="force"))
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1), layout="constrained")
        found.plot(ax=left)
        left.set_title("")
        found.plot_modes(ax=right)
        right.set_title("")
        right.set_xlim(11, 31)
    return canvas


def ringing() -> Figure:
    """Spectra of a light ball that was struck itself, and of forces near it."""
    balls = hc.Chain.from_materials(diameters="19.05 mm", materials="steel-52100", beads=41)
    row = balls.with_defects(diameters={21: "10 mm"})
    row = row.replace(precompression="20 N", held_by="force")
    found, velocities = hc.spectrum(row), np.zeros(41)
    velocities[20] = 1e-4
    times = np.arange(4000) / 200e3
    run = hc.simulate(row.replace(velocities=velocities), times=times)
    window, frequencies = np.hanning(4000) / 1000, np.fft.rfftfreq(4000, 1 / 200e3)
    sensor = run.sensor_force("ball 20").force
    curves = {"contact 21": (run.force(21), "-"), "sensor in ball 20": (sensor, "--")}
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1), layout="constrained")
        speed = np.abs(np.fft.rfft(window * run.velocity(21)))
        left.plot(frequencies / 1e3, 1e6 * speed)
        left.set_ylabel("velocity of ball 21 [µm/s]")
        for name, (force, style) in curves.items():
            change = np.abs(np.fft.rfft(window * (force - force.mean())))
            right.plot(frequencies / 1e3, 1e3 * change, style, label=name)
        right.set_ylabel("force [mN]")
        right.legend(loc="upper left")
        for axes in (left, right):
            axes.axvspan(0.0, found.host_edges[0, 1] / 1e3, color="0.92", zorder=0)
            axes.set(xlabel="frequency [kHz]", xlim=(0, 20), yscale="log")
        left.set_ylim(1e-3, 1e3)
        right.set_ylim(2e-4, 3e2)
        left.text(4.2, 0.85, "band", transform=left.get_xaxis_transform(), ha="center")
        frequency = found.frequencies[-1] / 1e3
        left.axvline(frequency, color="0.5", linewidth=0.8, linestyle="--", zorder=1)
    return canvas


HOWTO_FIGURES: Final = (
    losses,
    defect_chains,
    defects,
    rattling,
    interfaces,
    gaps,
    dimer_pulses,
    certainty,
    pads,
    localisation,
    light_bead,
    ringing,
    impurities,
)
