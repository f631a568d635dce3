"""Figures of how-to guides and explanations that show what their pages describe."""

import warnings
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import hertzchain as hc
from hertzchain.plotting.chains import draw_beads, material_legend, scale_bar
from hertzchain.plotting.colours import COLOURS
from hertzchain.plotting.style import BeadLocator, figure_style, label_log_axis
from hertzchain.theory import long_wave_velocity, sen_manciu_velocity


def chain_rows(chains: dict[str, hc.Chain], height: float) -> Figure:
    """Draw chains below each other, with their titles."""
    with figure_style():
        canvas, rows = plt.subplots(len(chains), 1, figsize=(8.0, height))
        for axes, (title, chain) in zip(rows, chains.items(), strict=True):
            hc.plot_chain(chain, ax=axes)
            scale_bar(chain, axes)
            axes.set_anchor("W")
            axes.set_title("")
            axes.set_title(title, loc="left", x=0.0)
            axes.set_axis_off()
    return canvas


def real_chains() -> Figure:
    """Kinds of real chains."""
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=16)
    experiment = hc.Chain.from_materials([5e-3, 5e-3, 4.75e-3, 4.5e-3, 4e-3], "steel-52100")
    taper = hc.Chain.tapered("forward-linear", 0.05, beads=8)
    return chain_rows(
        {
            "a PTFE striker, five steel balls, a wall":
                experiment.struck_by(radius=4e-3, material="ptfe").replace(right_wall=hc.Wall()),
            "a repeated cell": hc.Chain.periodic(
                [9.5e-3, 4.8e-3], cells=7, materials=["steel-316", "ptfe"]
            ),
            "small beads between those of a taper": taper.decorated(0.4, between=2),
            "a different bead": balls.with_defects({6: 3e-3}, material="brass"),
            "random radii": balls.with_scatter(4, relative=0.15),
        },
        6.0,
    )  # fmt: skip


def chain_files() -> Figure:
    """Chains of the first examples of chain files."""
    return chain_rows(
        {
            "taper = \"forward-linear\", rate = 0.006, the first 20 of 60 beads":
                hc.Chain.tapered("forward-linear", 0.006, beads=20),
            "radii = [5.0, 1.5, 5.0, 1.5, 5.0, 1.5, 5.0]":
                hc.Chain.from_radii([5.0, 1.5, 5.0, 1.5, 5.0, 1.5, 5.0]),
            "taper = \"uniform\", the first 12 of 100 beads": hc.Chain.uniform(12),
        },
        4.2,
    )  # fmt: skip


def teaching() -> Figure:
    """Newton's cradle over many impacts, and the force behind touching and separate balls."""
    material = {"diameters": "20 mm", "materials": "steel-52100"}
    cradle = hc.Chain.from_materials(**material, beads=5, loss=hc.Restitution(0.95))
    velocities = np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    after = []
    for impact in range(40):
        run = hc.simulate(cradle.replace(velocities=velocities), until="20 ms")
        velocities = -run.velocities[-1]
        # Every second impact has the opposite direction.
        after.append(run.velocities[-1] if impact % 2 == 0 else velocities[::-1])
    balls = hc.Chain.from_materials(**material, beads=20).struck_by(velocity="0.1 m/s")
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.0), layout="constrained")
        for ball, marker in zip((5, 4, 3, 2, 1), "o^sDv", strict=True):
            left.plot(
                range(1, 41), 1e3 * np.array(after)[:, ball - 1], color=COLOURS[ball],
                marker=marker, markersize=3.5, linewidth=0.7, label=f"ball {ball}",
            )  # fmt: skip
        left.set_xlabel("impact")
        left.xaxis.set_major_locator(BeadLocator())
        left.set_ylabel("velocity [mm/s]")
        left.legend(ncols=2)
        for gap, label, colour, dashes in (
            (0.0, "touching", COLOURS[0], "-"), ("5 um", "gaps of 5 µm", COLOURS[2], "--"),
        ):  # fmt: skip
            row = balls.replace(right_wall=hc.Wall(), gaps=gap)
            run = hc.simulate(row, until="4 ms", times=4001)
            right.plot(1e3 * run.times, run.sensor("wall"), dashes, color=colour, label=label)
        right.set_xlabel("time [ms]")
        right.set_ylabel("force on the wall [N]")
        right.set_xlim(0.0, 4.0)
        right.legend(loc="upper right")
    return canvas


def solitary_waves() -> Figure:
    """Profiles of solitary waves, and their speed under precompression."""
    wave = hc.solitary_wave()
    balls = {"diameters": "10 mm", "materials": "steel-52100"}
    held = hc.Chain.from_materials(**balls, beads=100).replace(
        precompression="10 N", held_by="force"
    )
    sound = hc.spectrum(held).sound_speed
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
        for speed, marker, colour in (("0.05 m/s", "o", COLOURS[1]), ("0.4 m/s", "^", COLOURS[2])):
            row = hc.Chain.from_materials(**balls, beads=60).struck_by(velocity=speed)
            run = hc.simulate(row, times=400)
            pulse = run.pulse()
            steps = (run.times - pulse.peak_time[39]) / pulse.residence[39]
            shown = np.abs(steps) < 3.0
            scaled = run.velocities[shown, 39] / pulse.velocity[39]
            left.plot(steps[shown], scaled, marker, color=colour, markersize=4, fillstyle="none",
                      label=f"impact at {speed}")  # fmt: skip
        distance = np.linspace(-3.0, 3.0, 301)
        left.plot(distance, wave.velocity(distance), color=COLOURS[0], label="theory", zorder=0)
        left.set_xlabel("time / time from ball to ball")
        left.set_ylabel("velocity / largest velocity")
        left.set_ylim(-0.05, 1.5)
        left.legend(loc="upper right")
        found = []
        for speed in np.geomspace(0.003, 0.37, 12):
            struck = held.replace(velocities=[speed] + [0.0] * 99)
            pulse = hc.simulate(struck, until="1.3 ms", times=0).pulse()
            found.append((pulse.peak_force[49] / 10.0, pulse.speed[39:60].mean()))
        ratio, measured = np.array(found).T
        right.plot(ratio, measured, "o", color=COLOURS[1], fillstyle="none", label="simulation")
        ratios = np.geomspace(1.0001, 10.0, 100)
        right.plot(ratios, sound * hc.theory.precompressed_speed(ratios), color=COLOURS[0],
                   label="long-wave theory")  # fmt: skip
        mass, stiffness = held.masses[0], held.stiffness[0]
        forces = 10.0 * ratios
        crest = (forces / wave.peak_force(1.0, mass, stiffness)) ** (5.0 / 6.0)
        free = [10e-3 * wave.speed(float(v), mass, stiffness) for v in crest]
        right.plot(ratios, free, "--", color=COLOURS[2], label="no precompression")
        right.set_xscale("log")
        label_log_axis(right.xaxis)
        right.set_ylim(300.0, 900.0)
        right.set_xlabel("largest / static force")
        right.set_ylabel("speed [m/s]")
        right.legend(loc="upper left")
    return canvas


def many_chains() -> Figure:
    """Momentum in random chains, and the sensitivity of a force to all radii."""
    equal = hc.Chain.uniform(40)
    table = hc.propagate_many([equal.with_scatter(seed, relative=0.05) for seed in range(2000)])
    momentum, same = table.momentum[:, 29], hc.propagate(equal).momentum[29]
    chain = hc.Chain.tapered("forward-linear", 0.005, beads=40)
    gradient = hc.local_rate_gradient(chain, "peak_force", bead=30)[1]
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.0))
        left.hist(momentum, bins=60, color=COLOURS[5])
        left.axvline(same, color=COLOURS[0], linewidth=1.2, label="equal beads")
        left.axvline(np.median(momentum), color=COLOURS[2], linestyle="--", label="median")
        left.set_xlabel("momentum of bead 30")
        left.set_ylabel("number of chains")
        left.legend()
        right.bar(np.arange(2, 41), gradient[1:], color=COLOURS[1])
        right.set_xlabel("bead $j$, from 2")
        right.xaxis.set_major_locator(BeadLocator())
        right.set_ylabel("sensitivity of the force,\n$\\partial\\ln F_{30} / \\partial\\ln R_j$")
    return canvas


def closed_forms() -> Figure:
    """The solitary wave and its approximations: profile and tail."""
    wave = hc.solitary_wave()
    distance = np.linspace(-3.0, 3.0, 601)
    profiles = {
        "exact": (wave.velocity(distance), "0.75", "-"),
        "long-wave theory": (long_wave_velocity(distance), COLOURS[1], "--"),
        "Sen and Manciu": (sen_manciu_velocity(distance), COLOURS[2], "-"),
    }
    # The formula of Sen and Manciu is drawn on the exact curve, from which it hardly differs.
    widths = {"exact": 5.0, "long-wave theory": 1.1, "Sen and Manciu": 1.1}
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.0))
        for label, (profile, colour, dashes) in profiles.items():
            left.plot(distance, profile, dashes, color=colour, linewidth=widths[label], label=label)
        far = np.linspace(0.0, 7.0, 141)
        for label, function in {"exact": wave.velocity, "long-wave theory": long_wave_velocity,
                                "Sen and Manciu": sen_manciu_velocity}.items():  # fmt: skip
            values = function(far)
            shown = values > 0.0
            colour, dashes = profiles[label][1:]
            right.semilogy(far[shown], values[shown], dashes, color=colour, linewidth=widths[label])
        left.set_xlabel(r"distance from the crest $\xi$ [beads]")
        left.set_ylabel("velocity, relative to the crest")
        right.legend(*left.get_legend_handles_labels(), loc="lower left")
        right.set_xlabel(r"distance from the crest $\xi$ [beads]")
        right.set_ylim(1e-40, 3.0)
        right.set_ylabel("velocity, relative to the crest")
    return canvas


def theory() -> Figure:
    """Velocity and arrival time of the BCA, relative to the simulation."""
    tapers = {"backward-exponential": 0.05, "forward-exponential": 0.05,
              "backward-linear": 0.5, "forward-linear": 0.009}  # fmt: skip
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.0))
        for number, (taper, rate) in enumerate(tapers.items()):
            chain = hc.Chain.tapered(taper, rate, beads=100)
            comparison = hc.bca(chain).compare(hc.propagate(chain))
            bead = np.arange(2, 98)
            dashes = ("-", "--", "-.", ":")[number]
            for axes, quantity in ((left, "velocity"), (right, "arrival")):
                error = 100.0 * comparison.errors(quantity)[1:97]
                axes.plot(
                    bead,
                    error,
                    dashes,
                    color=COLOURS[number],
                    label=f"{taper}, ${'S' if 'linear' in taper else 'q'}$ = {rate:g}",
                )
        left.set_ylabel("error of the velocity [%]")
        right.set_ylabel("error of the arrival time [%]")
        right.legend(loc="lower right")
        for axes in (left, right):
            axes.set_xlabel("bead $k$")
            axes.axhline(0.0, color="0.6", linewidth=0.7)
    return canvas


def numerics() -> Figure:
    """Error of the velocity maxima as a function of the tolerance."""
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=60)
    best = hc.simulate(chain, times=0, rtol=1e-14).pulse().velocity[1:-1]
    tolerances = np.logspace(-13, -6, 15)
    errors, steps = [], []
    for tolerance in tolerances:
        run = hc.simulate(chain, times=0, rtol=tolerance)
        errors.append(np.abs(run.pulse().velocity[1:-1] / best - 1.0).max())
        steps.append(run.steps)
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.0))
        left.loglog(tolerances, errors, "o-", color=COLOURS[1])
        left.loglog(tolerances, tolerances, "--", color="0.5", linewidth=0.8)
        left.annotate("error = rtol", (1e-9, 1e-9), xytext=(6, -12), textcoords="offset points",
                      color="0.35")  # fmt: skip
        left.set_ylabel("largest error of a velocity")
        right.loglog(tolerances, steps, "o-", color=COLOURS[2])
        right.set_ylabel("steps")
        label_log_axis(right.yaxis)
        for axes in (left, right):
            axes.set_xlabel("tolerance per step, rtol")
    return canvas


def propagation() -> Figure:
    """Velocities around the crest of a pulse: most beads do not move noticeably."""
    chains = {
        "backward-exponential, q = 0.05": hc.Chain.tapered("backward-exponential", 0.05, beads=80),
        "uniform": hc.Chain.uniform(80),
        "forward-exponential, q = 0.05": hc.Chain.tapered("forward-exponential", 0.05, beads=80),
    }
    with figure_style():
        canvas, axes = plt.subplots(figsize=(6.2, 3.6))
        for number, (label, chain) in enumerate(chains.items()):
            time = float(hc.propagate(chain).peak_time[39])
            velocity = hc.simulate(chain, until=time, times=[time]).velocities[-1]
            moved = np.abs(velocity) / np.abs(velocity[39])
            shown = moved > 0.0
            place = np.arange(-39, 41)
            axes.semilogy(place[shown], moved[shown], "ox+"[number], color=COLOURS[number + 1],
                          label=label)  # fmt: skip
        axes.set_xlabel("bead relative to the crest (positive: ahead)")
        axes.set_ylabel("speed, relative to the crest")
        axes.set_ylim(1e-12, 10.0)
        axes.set_xlim(-39.5, 12.0)
        axes.legend(loc="lower left")
    return canvas


def _crystal() -> hc.Chain:
    """The chain of the page on precompressed crystals."""
    kinds = ["silicon-nitride", "steel-52100"]
    balls = hc.Chain.periodic(["9.53 mm"] * 2, cells=10, materials=kinds)
    return balls.replace(precompression="20 N", held_by="force")


def precompressed() -> Figure:
    """Bands and transfer function of a diatomic crystal, as the calls in the caption draw them."""
    crystal = hc.spectrum(_crystal())
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.4))
        crystal.plot(ax=left)
        crystal.plot_transfer(16, ax=right)
        for axes in (left, right):
            axes.set_title("")
    return canvas


def transfer_function() -> Figure:
    """Transfer function of a crystal with loss, by theory and by simulation."""
    lossy = _crystal().replace(loss=hc.Viscoelastic("3 us"))
    moments = np.linspace(0.0, 400e-6, 401)
    pulse = 0.02 * np.exp(-(((moments - 200e-6) / 24e-6) ** 2) / 2)
    pulse[[0, -1]] = 0.0
    drive, times = hc.TableDrive(moments, pulse), np.arange(12_500) / 50e3
    run = hc.simulate(lossy.replace(drive=drive), times=times)
    response = np.fft.rfft(run.forces[:, 16] - lossy.precompression)
    measured = np.abs(response / np.fft.rfft(drive.value(times)))
    frequency = np.fft.rfftfreq(len(times), times[1]) / 1e3
    shown = (frequency > 0.0) & (frequency < 12.0) & (np.arange(len(frequency)) % 20 == 0)
    with figure_style():
        axes = hc.spectrum(lossy).plot_transfer(16)
        axes.lines[0].set_label("theory")
        axes.semilogy(frequency[shown], measured[shown], "o", color=COLOURS[0], markersize=3.0,
                      markerfacecolor="none", label="simulation")  # fmt: skip
        axes.legend()
        axes.set_title("")
    canvas = axes.figure
    assert isinstance(canvas, Figure)
    return canvas


def design_protector() -> Figure:
    """A row of steel and PTFE balls, a row of equal balls, and the forces behind both."""
    chain = hc.Chain.from_materials(
        "2.38125 mm", "steel-52100", beads=12, velocity="1 m/s",
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip
    balls = hc.vary.balls(materials=["steel-52100", "ptfe"], diameters=["4.7625 mm"])
    problem = hc.Design(
        chain, minimise="wall_force.peak", vary=[balls], subject_to={"length": "<= 60 mm"}
    )
    found = hc.design(problem)
    equal = found.references["row of equal balls"].chain
    with figure_style(), warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        # Single beads bounce after the last maximum that is drawn.
        warnings.simplefilter("ignore", hc.IncompleteWarning)
        # One above the other, the panels are legible on a narrow page.
        canvas, panels = plt.subplots(
            4, 1, figsize=(6.4, 7.2), layout="constrained", height_ratios=[1.0, 3.2, 1.0, 3.2]
        )
        for (row, axes), (name, each) in zip(
            panels.reshape(2, 2), {"equal balls": equal, "design": found.chain}.items(), strict=True
        ):
            draw_beads(each, 1e3, row)
            row.set_aspect("equal")
            row.autoscale_view()
            row.set_axis_off()
            row.set_title(name, pad=10.0)
            for label, law, colour, dashes in (
                ("elastic", None, COLOURS[0], "-"),
                ("yield at 1.6 $Y$", hc.ElasticPlastic(), COLOURS[2], "--"),
            ):
                run = hc.simulate(each.replace(loss=law), until=1.3e-3, times=2000)
                force = run.wall_force().force
                axes.plot(1e3 * run.times, force, dashes, color=colour, label=label)
            axes.set_xlim(0.0, 1.3)
            axes.set_ylabel("force on the wall [N]")
            axes.set_xlabel("time [ms]")
        panels[3].set_ylim(panels[1].get_ylim())
        lines, _ = panels[1].get_legend_handles_labels()
        material_legend([found.chain], panels[1])
        kinds = panels[1].get_legend().legend_handles
        panels[1].get_legend().remove()
        canvas.legend(handles=[*kinds, *lines], loc="outside upper center", ncols=4)
    return canvas


def designs() -> Figure:
    """Attenuation in chains of heavy and light beads, and published ratios that transmit best."""
    ratios = np.geomspace(0.05, 0.5, 400)  # without the resonance at 0.58
    chains = [hc.Chain.dimer(mass_ratio=ratio, beads=100) for ratio in ratios]
    velocity = hc.propagate_many(chains).velocity
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.4))
        axes.loglog(ratios, 1.0 - velocity[:, 90] / velocity[:, 30], color=COLOURS[1],
                    label="simulation")  # fmt: skip
        for known in (0.3428, 0.1548, 0.0901, 0.0615):
            line = axes.axvline(known, color=COLOURS[2], linestyle="--", linewidth=1.0)
        line.set_label("no attenuation: Jayaprakash et al. (2011)")
        axes.set_xticks([0.05, 0.1, 0.2, 0.4], labels=["0.05", "0.1", "0.2", "0.4"])
        axes.minorticks_off()
        axes.set_xlabel("mass of the light beads / mass of the heavy beads")
        axes.set_ylabel("lost velocity $1 - v_{91}/v_{31}$")
        axes.set_ylim(1e-6, 1.0)
        # Above the axes, where no curve is.
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    return canvas


PAGE_FIGURES: Final = (
    real_chains, chain_files, many_chains, closed_forms, theory, numerics, teaching,
    solitary_waves, propagation, precompressed, transfer_function, design_protector, designs,
)  # fmt: skip
