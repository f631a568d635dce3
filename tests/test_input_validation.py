"""All public functions with invalid arguments raise `InputError` with one sentence."""

import inspect
import itertools
import warnings
from contextlib import nullcontext

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import Chain

# Classes that users do not create; only their methods are called.
RESULTS = (
    "BodyForce", "Budget", "Calibration", "DefectScan", "DesignResult", "Distribution",
    "EffectiveChain",
    "EffectivePulse", "EnergyBalance", "EnergyFlux", "Gradient",
    "FitResult", "Forecast", "Fronts", "LabSheet", "LossComparison", "Posterior", "TraceComparison",
    "HertzRange", "Horizon", "LeadingPulse", "PulseTable", "Reflection", "Run", "RunTable",
    "ScatterCauses", "Scoreboard", "SensorPassage",
    "SensorForce", "SolitaryWave", "Spectrum", "State", "StaticState", "VelocityPeaks", "Verdict",
    "WallForce", "Wave", "WaveEvent", "Waves",
)  # fmt: skip
# Methods for internal use, whose arguments have been checked.
INTERNAL = (
    "factors", "row", "strength", "resolved", "loading_force", "loading_overlap", "stored_energy",
    "largest_overlap", "damper", "dent", "yield_ratio",
)  # fmt: skip
LAWS = {
    "Dashpot": hc.Dashpot(0.1), "Elastic": hc.Elastic(), "Restitution": hc.Restitution(0.9),
    "ElasticPlastic": hc.ElasticPlastic(yield_overlap=0.1), "Viscoelastic": hc.Viscoelastic(0.1),
    "UnloadingRatio": hc.UnloadingRatio(0.1), "VelocityPower": hc.VelocityPower(0.1, 1.5),
    "WaltonBraun": hc.WaltonBraun(0.5),
}  # fmt: skip
# Laws without a parameter that follows from one coefficient of restitution.
NO_RESTITUTION = ("Elastic.from_restitution",)
OTHERS_OF_LAWS = {"VelocityPower": {"alpha": 1.5}}
TRIED = {
    "None": None, "3": 3, "text": "x", "empty": [], "nan": float("nan"), "object": object(),
    "array": np.array([1.0, 2.0]), "ragged": [[1, 2], [3]], "huge": 10**400, "True": True,
}  # fmt: skip


def tried(function, /, **good):
    """A public function and valid arguments."""
    return function, good


def styled(width):
    """Enter the block, where the width is checked."""
    with hc.figure_style(width):
        pass


def public_calls(folder):
    """Public functions with valid arguments, by name."""
    chain, tapered = Chain.uniform(9), Chain.tapered("forward-linear", 0.005, beads=30)
    walled = chain.replace(right_wall=hc.Wall())
    balls = Chain.from_materials(5e-3, "brass", beads=9, velocity=0.01)
    small = chain.decorated(0.2)
    run, pulse = hc.simulate(walled, until=25.0, times=50), hc.bca(chain)
    longer = hc.simulate(walled, until=40.0, times=400)
    budget, compared, wave = run.budget(), pulse.compare(pulse), hc.solitary_wave()
    table = hc.propagate_many([[1.0, 1.0, 1.0]])
    runs = hc.simulate_many([chain])
    held = chain.replace(precompression=1.0, held_by="force")
    lines, sent = hc.spectrum(held), {"drive": "force", "at": 1}
    scales, state = hc.Scales.of(balls), folder / "state.npz"
    stored = hc.stream(chain, folder / "run", times=[1.0, 2.0])
    hc.save_state(run.state, state)
    hc.save_run(run, folder / "run.nc")
    run.pulse().save(folder / "pulse.nc")
    board = hc.scoreboard(theories=["bca", "local-rate"])
    plan = {"chain": {"taper": "uniform"}, "axes": {"beads": [5, 6]}}
    hc.sweep(plan, folder / "sweep")
    steel = Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=0.01)
    sheet = hc.lab_sheet(steel, sensors=[2], speeds=[0.01, 0.02])
    moved = hc.simulate(steel, until=2e-4, times=101)
    signal = {"ball 4 [N]": moved.sensor(4)}
    traces = hc.Traces.from_arrays(moved.times, signal, noise=0.01)
    fitted = hc.fit(traces, steel, free=["time_offset"])
    laws_compared = hc.compare_losses(traces, steel, laws=["elastic"], free=["time_offset"])
    planned = hc.forecast(
        steel, ["ball 4"], noise=0.1, interval=2e-6, free=["time_offset"], until=2e-4
    )
    posterior = hc.Posterior(("a",), np.zeros((4, 1)), 0.5, 1.0, 100, np.zeros(1), ("s",))
    table_of_traces = folder / "traces.csv"
    rows = zip(1e6 * moved.times, moved.sensor(4), strict=True)
    table_of_traces.write_text(
        "time [us],ball 4 [N]\n" + "".join(f"{time},{force}\n" for time, force in rows)
    )
    radii = hc.vary.radii(0.5, 1.0, by="common")
    problem = hc.Design(hc.Chain.uniform(4), maximise="velocity@last", vary=[radii])
    designed = hc.design(problem, budget=150)
    return {
        "Design": tried(
            hc.Design,
            chain=chain,
            minimise="velocity@last",
            maximise=None,
            match=None,
            vary=[radii],
            subject_to={"length": "<= 20"},
            scatter=None,
            until=None,
            model="simulation",
        ),
        "Scatter": tried(hc.Scatter, radius=0.01, grade=None, measure="mean", samples=10),
        "Scatter.sample": tried(hc.Scatter(radius=0.01, samples=3).sample, chain=chain, seed=2),
        "distribution": tried(
            hc.distribution,
            chain=chain,
            quantity="velocity@3",
            scatter=hc.Scatter(radius=0.01, samples=3),
            seed=2,
            threads=1,
            progress=None,
        ),
        "scatter_causes": tried(
            hc.scatter_causes,
            chain=chain,
            quantity="velocity@3",
            scatter=hc.Scatter(radius=0.01, speed=0.01, samples=3),
            seed=2,
            threads=1,
            progress=None,
        ),
        "ScatterCauses.to_dataframe": tried(
            hc.scatter_causes(
                chain, "velocity@3", hc.Scatter(radius=0.01, speed=0.01, samples=3)
            ).to_dataframe
        ),
        "Distribution.plot": tried(
            hc.distribution(chain, "velocity@3", hc.Scatter(radius=0.01, samples=3)).plot, ax=None
        ),
        "Distribution.to_dataframe": tried(
            hc.distribution(chain, "velocity@3", hc.Scatter(radius=0.01, samples=3)).to_dataframe
        ),
        "Distribution.percentile": tried(
            hc.distribution(chain, "velocity@3", hc.Scatter(radius=0.01, samples=3)).percentile,
            percent=50.0,
        ),
        "design": tried(
            hc.design,
            problem=problem,
            budget=150,
            method="auto",
            seed=0,
            points=2,
            store=None,
            threads=1,
            progress=None,
        ),
        "Design.evaluate": tried(problem.evaluate, chain=chain),
        "DesignResult.objective_of": tried(designed.objective_of, found=designed.verified),
        "DesignResult.plot": tried(designed.plot, kind="history", ax=None),
        "Traces": tried(hc.Traces, shots=traces.shots),
        "Traces.from_arrays": tried(
            hc.Traces.from_arrays, times=moved.times, signals=signal, noise=0.01
        ),
        "Traces.with_scaled_times": tried(traces.with_scaled_times, factor=0.5),
        "Traces.between": tried(traces.between, begin=None, until=1.0),
        "Traces.merge": tried(
            traces.merge,
            other=hc.Traces.from_arrays(
                moved.times, {"wall [N]": next(iter(signal.values()))}, noise=0.01
            ),
        ),
        "Traces.to_dataframe": tried(traces.to_dataframe),
        "Traces.plot": tried(traces.plot, legend=False, ax=None),
        "load_traces": tried(
            lambda path, sensors, channels, noise: hc.load_traces(
                path, sensors=sensors, channels=channels, noise=noise
            ),
            path=table_of_traces,
            sensors=["ball 4"],
            channels=False,
            noise=0.01,
        ),
        "example_experiment": tried(lambda shot: hc.example_experiment(shot), shot="fast"),
        "forecast": tried(
            hc.forecast,
            chain=steel,
            sensors=["ball 4"],
            noise=0.1,
            interval=2e-6,
            free=["time_offset"],
            also_free=["stiffness"],
            priors=None,
            start=None,
            until=2e-4,
        ),
        "fit": tried(
            hc.fit,
            traces=traces,
            chain=steel,
            free=["time_offset"],
            also_free=["stiffness"],
            priors={},
            start={},
            starts=1,
            diagnose=False,
            progress=None,
        ),
        "compare_losses": tried(
            hc.compare_losses,
            traces=traces,
            chain=steel,
            laws=["elastic"],
            free=["time_offset"],
            also_free=["stiffness"],
            priors={},
            start={},
            progress=None,
        ),
        "scan_defects": tried(hc.scan_defects, result=fitted, kind="gap", progress=None),
        "Forecast.summary": tried(planned.summary, width=88),
        "LossComparison.summary": tried(laws_compared.summary, width=88),
        "Posterior.summary": tried(posterior.summary, width=88),
        "DefectScan.fit": tried(hc.scan_defects(fitted).fit, candidates=1),
        "DefectScan.plot": tried(hc.scan_defects(fitted).plot, legend=True, ax=None),
        "DefectScan.summary": tried(hc.scan_defects(fitted).summary, width=88),
        "FitResult.bic": tried(fitted.bic, inflation=1.0),
        "FitResult.summary": tried(fitted.summary, width=88),
        "FitResult.plot": tried(fitted.plot, sensor="ball 4", shot=1, ax=None),
        "FitResult.sample": tried(fitted.sample, steps=10, seed=0, progress=None),
        "Run.compare": tried(moved.compare, traces=traces, time_offset=0.0),
        "TraceComparison.summary": tried(moved.compare(traces).summary, width=88),
        "TraceComparison.plot": tried(moved.compare(traces).plot, sensor="ball 4", ax=None),
        "Chain": tried(
            Chain,
            radii=[1.0, 1.0],
            exponent=1.5,
            taper=None,
            taper_parameters=(),
            masses=None,
            stiffness=None,
            units="scaled",
            materials=None,
            velocities=None,
            gaps=None,
            strikers=0,
            precompression=0.0,
            held_by="walls",
            gravity=0.0,
            left_wall=None,
            right_wall=None,
            drive=None,
            loss=None,
        ),
        "Chain.tapered": tried(
            Chain.tapered, taper="forward-linear", rate=0.01, beads=5, exponent=1.5
        ),
        "Chain.uniform": tried(Chain.uniform, beads=5, exponent=1.5),
        "Chain.from_radii": tried(Chain.from_radii, radii=[1, 2], exponent=1.5),
        "Chain.from_materials": tried(
            Chain.from_materials,
            radii=[0.005, 0.004],
            materials="brass",
            beads=None,
            velocity=0.01,
            gravity=0.0,
        ),
        "Chain.periodic": tried(Chain.periodic, cell=[1.0, 0.5], cells=3, materials=None),
        "Chain.periodic, by diameters": tried(Chain.periodic, diameters=[1.0, 0.5], cells=3),
        "Chain.dimer": tried(Chain.dimer, mass_ratio=0.5, beads=5, exponent=1.5),
        "Chain.decorated": tried(chain.decorated, ratio=0.3, between=1, material=None),
        "Chain.decorated, by radius": tried(chain.decorated, radius=0.3),
        "Chain.decorated, by diameter": tried(chain.decorated, diameter=0.6),
        "Chain.decorated, of a material": tried(balls.decorated, ratio=0.3, material="brass"),
        "Chain.with_defects": tried(
            chain.with_defects, radii={3: 0.5}, diameters=None, material=None
        ),
        "Chain.with_scatter": tried(chain.with_scatter, seed=1, relative=0.1, beads="2:"),
        "Chain.with_scatter, by grade": tried(balls.with_scatter, seed=1, grade=100),
        "Chain.struck_by": tried(
            chain.struck_by, velocity=1.0, radius=1.0, mass=1.0, stiffness=1.0, count=1, gap=0.0
        ),
        "Chain.struck_by, by height": tried(balls.replace(velocities=None).struck_by, height=0.01),
        "Chain.struck_by, by diameter": tried(chain.struck_by, diameter=2.0),
        "Chain.struck_by, of a material": tried(
            balls.replace(velocities=None).struck_by, material="brass"
        ),
        "Chain.with_cap": tried(chain.with_cap, mass=1.0, stiffness=1.0),
        "Chain.with_cap, by frequency": tried(
            chain.replace(right_wall=hc.Wall(1.0, exponent=1)).with_cap, frequency=0.5
        ),
        "Chain.with_cap, of a material": tried(balls.with_cap, mass=0.01, material="brass"),
        "Chain.replace": tried(chain.replace, gravity=0.0),
        "Material.replace": tried(hc.material("brass").replace, young=1e11),
        "Chain.loading_force": tried(chain.loading_force, overlaps=[0.1] * (chain.beads - 1)),
        "Chain.with_contacts": tried(balls.with_contacts, shapes=hc.Cone(60.0)),
        "Cone": tried(hc.Cone, half_angle=60.0),
        "Cone.stiffness": tried(hc.Cone(60.0).stiffness, modulus=1e9),
        "Pad": tried(hc.Pad, stiffness=1e6),
        "CrossedCylinders": tried(
            hc.CrossedCylinders, radius=0.005, other_radius=0.005, angle=90.0
        ),
        "CrossedCylinders.stiffness": tried(hc.CrossedCylinders(0.005).stiffness, modulus=1e9),
        "SineBurst": tried(
            hc.SineBurst, amplitude=1.0, frequency=1.0, cycles=5.0, of="force", window="hann"
        ),
        "SineBurst.value": tried(hc.SineBurst(1.0, 1.0).value, times=[1.0]),
        "StepDrive": tried(hc.StepDrive, amplitude=1.0, rise=1.0, of="force"),
        "StepDrive.value": tried(hc.StepDrive(1.0).value, times=[1.0]),
        "TableDrive": tried(hc.TableDrive, times=[0.0, 1.0], values=[0.0, 1.0], of="force"),
        "TableDrive.value": tried(hc.TableDrive([0, 1], [0, 1]).value, times=[1.0]),
        "explore": tried(hc.explore, chain=chain, height=500),
        "save_page": tried(
            hc.save_page, chain=chain, path=folder / "page.html", other=chain, sensors=[2]
        ),
        "lab_sheet": tried(
            hc.lab_sheet,
            chain=balls,
            sensors=[2],
            speeds=[0.01, 0.02],
            title="Row",
            blank=False,
            until=1e-3,
        ),
        "LabSheet.save": tried(sheet.save, path=folder / "sheet.md"),
        "equilibrium": tried(hc.equilibrium, chain=chain),
        "hertz_range": tried(hc.hertz_range, chain=balls, overlaps=None),
        "Dashpot": tried(hc.Dashpot, gamma=1.0, attractive=True),
        "Restitution": tried(hc.Restitution, coefficient=0.9, attractive=True),
        "Restitution.damping": tried(hc.Restitution(0.9).damping, exponent=1.5),
        "UnloadingRatio": tried(hc.UnloadingRatio, ratio=0.1),
        "VelocityPower": tried(hc.VelocityPower, gamma=1.0, alpha=1.0, attractive=True),
        "Viscoelastic": tried(hc.Viscoelastic, time=0.1, attractive=False),
        "WaltonBraun": tried(hc.WaltonBraun, ratio=0.5),
        "Elastic": tried(hc.Elastic),
        "ElasticPlastic": tried(hc.ElasticPlastic, yield_overlap=0.1),
        "ElasticPlastic, by pressure": tried(hc.ElasticPlastic, yield_pressure=1e9),
        "ElasticPlastic, by factor": tried(hc.ElasticPlastic, factor=2.8),
        **{
            f"{name}.restitution": tried(
                law.restitution, speed=1.0, reduced_mass=0.5, stiffness=1.0, exponent=1.5
            )
            for name, law in LAWS.items()
        },
        **{
            f"{type(law).__name__}.from_restitution": tried(
                law.from_restitution,
                coefficient=0.9,
                speed=1.0,
                chain=Chain.uniform(4),
                contact=1,
                given=OTHERS_OF_LAWS.get(type(law).__name__, {}),
            )
            for law in LAWS.values()
        },
        "Material": tried(
            hc.Material,
            name="a",
            density=1000.0,
            young=1e9,
            poisson=0.3,
            yield_strength=None,
            source="",
        ),
        "material": tried(hc.material, name="brass"),
        "Scales": tried(hc.Scales, radius=1.0, mass=1.0, velocity=1.0, length=1.0, exponent=1.5),
        "Scales.of": tried(hc.Scales.of, chain=balls, velocity=None),
        "Scales.to_si": tried(scales.to_si, item=scales.to_scaled(balls)),
        "Scales.to_scaled": tried(scales.to_scaled, item=balls),
        "Scales.unit": tried(scales.unit, scale="force/velocity"),
        "Wall": tried(hc.Wall, stiffness=None, material=None, gap=0.0, exponent=None, loss=None),
        "Wall.of": tried(hc.Wall.of, name="brass", gap=0.0),
        "Wall.rigid": tried(hc.Wall.rigid, gap=0.0),
        "Run.save": tried(run.save, path=folder / "a.csv"),
        "Run.animate": tried(run.animate, path=folder / "a.gif", frames=2),
        "Run.save_forces": tried(run.save_forces, path=folder / "f.csv", sensors=[1]),
        "save_run": tried(hc.save_run, run=run, path=folder / "a.nc"),
        "export_sweep": tried(
            hc.export_sweep, dataset=hc.open_sweep(folder / "sweep"), path=folder / "a.csv"
        ),
        "plot_pulses": tried(
            hc.plot_pulses,
            pulses=[pulse],
            quantity="velocity",
            log=False,
            legend=True,
            ax=None,
        ),
        "plot_sweep": tried(
            hc.plot_sweep,
            dataset=hc.open_sweep(folder / "sweep"),
            quantity="velocity",
            log=False,
            levels=None,
            legend=True,
            ax=None,
            band=None,
            bead=3,
        ),
        "animate": tried(
            hc.animate,
            run=run,
            path=folder / "a.gif",
            frames=2,
            seconds=1.0,
            magnify=None,
            sensors=[2],
        ),
        "plot_chain": tried(hc.plot_chain, chain=chain, ax=None),
        "figure_style": tried(styled, width="120 mm"),
        "warm_up": tried(hc.warm_up, progress=None),
        "propagate": tried(hc.propagate, chain=chain, rtol=1e-8, progress=None),
        "propagate_many": tried(
            hc.propagate_many, chains=[chain], rtol=1e-8, threads=1, progress=None
        ),
        "simulate_many": tried(
            hc.simulate_many,
            chains=[chain],
            keep=["velocity"],
            sensors=[3],
            until=1.0,
            rtol=1e-8,
            max_steps=9999,
            check_range=True,
            threads=1,
            progress=None,
        ),
        "gradient": tried(
            hc.gradient,
            chain=chain,
            quantity="pulse.velocity",
            to=["radii"],
            bead=3,
            until=20.0,
            rtol=1e-6,
            max_steps=9999,
        ),
        "Gradient.to_dataframe": tried(hc.gradient(chain, "pulse.velocity@3").to_dataframe),
        "Gradient.to_xarray": tried(hc.gradient(chain, "pulse.velocity@3").to_xarray),
        "Gradient.plot": tried(hc.gradient(chain, "pulse.velocity@3").plot, name="radii", ax=None),
        "Gradient.relative": tried(hc.gradient(chain, "pulse.velocity@3").relative, name="radii"),
        "gradients": tried(
            hc.gradients,
            chain=chain,
            quantities=["pulse.velocity"],
            to=["radii"],
            bead=3,
            until=20.0,
            rtol=1e-6,
            max_steps=9999,
        ),
        "RunTable.exceeded_limits": tried(runs.exceeded_limits, index=0),
        "RunTable[...]": tried(lambda name: runs[name], name="velocity"),
        "Comparison": tried(hc.Comparison, pulse=pulse, reference=pulse),
        "Comparison.to_dataframe": tried(compared.to_dataframe),
        "Comparison.plot": tried(compared.plot, quantity="velocity", legend=True, ax=None),
        "Comparison.errors": tried(compared.errors, quantity="velocity"),
        "Comparison.worst": tried(compared.worst, quantity="velocity", first_bead=2, last_bead=5),
        "Comparison.rms": tried(compared.rms, quantity="velocity", first_bead=2, last_bead=5),
        "Comparison.worst_bead": tried(
            compared.worst_bead, quantity="velocity", first_bead=2, last_bead=5
        ),
        "Pulse": tried(
            hc.Pulse,
            chain=chain,
            method="x",
            velocity=np.ones(9),
            peak_time=None,
            arrival=None,
            peak_overlap=None,
            residence=None,
            velocity_error=None,
            velocity_spread=None,
            arrival_spread=None,
            peak_force_spread=None,
            notes={},
            restitution=1.0,
        ),
        "Pulse.column": tried(pulse.column, quantity="velocity"),
        "Pulse.unit": tried(pulse.unit, quantity="velocity"),
        "Pulse.compare": tried(pulse.compare, reference=pulse),
        "Pulse.save": tried(pulse.save, path=folder / "pulse.nc"),
        "Pulse.plot": tried(pulse.plot, quantity="velocity", label="a", legend=True, ax=None),
        "PulseTable.chain": tried(table.chain, index=0),
        "PulseTable.to_dataframe": tried(table.to_dataframe),
        "PulseTable.column": tried(table.column, quantity="velocity"),
        "PulseTable.plot": tried(table.plot, quantity="velocity", ax=None),
        "PulseTable[...]": tried(lambda index: table[index], index=0),
        "Budget.residual": tried(budget.residual, of="energy"),
        "Budget.to_dataframe": tried(budget.to_dataframe, of="energy"),
        "Budget.plot": tried(budget.plot, of="energy", horizon=None, legend=True, ax=None),
        "Run.force": tried(run.force, contact=1),
        "Run.overlap": tried(run.overlap, contact=1),
        "Run.position": tried(run.position, bead=1),
        "Run.sensor": tried(run.sensor, bead=1),
        "Run.sensor_force": tried(run.sensor_force, bead=1),
        "SensorForce.passages": tried(longer.sensor_force(5).passages, threshold=0.1),
        "Run.velocity": tried(run.velocity, bead=1),
        "Run.body_force": tried(hc.simulate(hc.Chain.uniform(3)).body_force),
        "Run.wall_force": tried(run.wall_force, side="right"),
        "LeadingPulse.weights": tried(
            run.leading_pulse().weights, times=run.times, velocities=run.velocities
        ),
        "Run.waves": tried(longer.waves, threshold=0.1, min_contacts=3),
        "EnergyFlux.balance": tried(longer.energy_flux().balance, before=4, after=9),
        "Run.reflection": tried(longer.reflection, before=4, after=9, since=0.0, until=None),
        "Run.horizon": tried(run.horizon, within=0.01, progress=None),
        "Run.velocity_peaks": tried(run.velocity_peaks, bead=3),
        "Waves.passing": tried(longer.waves().passing, contact=3),
        "Waves.at": tried(longer.waves().at, contact=3),
        "Waves.plot": tried(longer.waves().plot, legend=True, ax=None),
        "Run.pulse_width": tried(longer.pulse_width, bead=3),
        "Run.plot": tried(run.plot, quantity="velocity", relative=True, ax=None),
        "Run.plot_forces": tried(run.plot_forces, beads=[3], label="a run", legend=True, ax=None),
        "simulate": tried(
            hc.simulate,
            chain=chain,
            until=1.0,
            times=5,
            start=None,
            rtol=1e-13,
            max_steps=9999,
            check=True,
            progress=None,
        ),
        "load_drive": tried(
            hc.load_drive,
            path=folder / "no.csv",
            column=None,
            gain=None,
            offset=None,
            baseline=None,
        ),
        "load_chain": tried(hc.load_chain, path=folder / "no.toml"),
        "load_design": tried(hc.load_design, path=folder / "no.toml"),
        "chain_as_toml": tried(hc.chain_as_toml, chain=chain),
        "chain_from_toml": tried(hc.chain_from_toml, text=hc.chain_as_toml(chain), folder=folder),
        "load_state": tried(hc.load_state, path=state, chain=walled),
        "load_run": tried(hc.load_run, path=folder / "run.nc"),
        "load_pulse": tried(hc.load_pulse, path=folder / "pulse.nc"),
        "save_state": tried(hc.save_state, state=run.state, path=folder / "again.npz"),
        "StoredRun": tried(hc.StoredRun, folder=folder / "run"),
        "StoredRun.load": tried(stored.load, start=0.0, stop=5.0, skip_damaged=False),
        "StoredRun.parts": tried(lambda **given: [*stored.parts(**given)], skip_damaged=False),
        "stream": tried(
            hc.stream,
            chain=chain,
            folder=folder / "run",
            times=[1.0, 2.0],
            rtol=1e-13,
            progress=None,
        ),
        "attenuation": tried(hc.attenuation, chain=chain, velocity=1.0),
        "bca": tried(hc.bca, chain=chain, restitution=1.0),
        "disorder": tried(hc.disorder, chain=Chain.uniform(12), scatter=0.01, modulus_scatter=0.01),
        "effective_chain": tried(hc.effective_chain, chain=small, large=None),
        "hard_sphere": tried(hc.hard_sphere, chain=chain, restitution=1.0),
        "local_rate": tried(hc.local_rate, chain=tapered),
        "local_rate_gradient": tried(
            hc.local_rate_gradient, chain=tapered, quantity="velocity", bead=3
        ),
        "modified_bca": tried(hc.modified_bca, chain=tapered, coefficients="calibrated"),
        "solitary_wave": tried(hc.solitary_wave, exponent=1.5),
        "SolitaryWave.speed": tried(wave.speed, velocity=1.0, mass=1.0, stiffness=1.0),
        "SolitaryWave.momentum": tried(wave.momentum, velocity=1.0, mass=1.0),
        "SolitaryWave.energy": tried(wave.energy, velocity=1.0, mass=1.0),
        "SolitaryWave.velocity_from_force": tried(
            wave.velocity_from_force, force=1.0, mass=1.0, stiffness=1.0
        ),
        "SolitaryWave.peak_force": tried(wave.peak_force, velocity=1.0, mass=1.0, stiffness=1.0),
        "SolitaryWave.velocity": tried(wave.velocity, distance=0.0),
        "SolitaryWave.velocity.width": tried(wave.velocity.width, level=0.5),
        "SolitaryWave.velocity.crest_derivative": tried(wave.velocity.crest_derivative, order=2),
        "spectrum": tried(hc.spectrum, chain=held),
        "Spectrum.transfer": tried(lines.transfer, frequencies=[0.1], bead=2, **sent),
        "Spectrum.transfer_force": tried(
            lines.transfer_force, frequencies=[0.1], contact=2, **sent
        ),
        "Spectrum.to_dataframe": tried(lines.to_dataframe),
        "Spectrum.to_xarray": tried(lines.to_xarray),
        "Spectrum.bands": tried(lines.bands, phase=0.1, cell=None),
        "Spectrum.group_velocity": tried(lines.group_velocity, phase=0.1, cell=None),
        "Spectrum.band_edges": tried(lines.band_edges, cell=None),
        "Spectrum.gaps": tried(lines.gaps, cell=None),
        "Spectrum.plot": tried(lines.plot, kind="modes", cell=None, ax=None),
        "Spectrum.plot_modes": tried(lines.plot_modes, modes=[1, 2], ax=None),
        "Spectrum.plot_transfer": tried(
            lines.plot_transfer, contact=2, frequencies=[0.1, 0.2], ax=None, **sent
        ),
        "EffectiveChain.spacing": tried(hc.effective_chain(small).spacing, velocity=1.0),
        "piecewise_local_rate": tried(hc.piecewise_local_rate, chain=tapered),
        "striker_train": tried(hc.striker_train, mass_ratio=2.0, velocity=1.0),
        "sweep": tried(
            hc.sweep,
            specification=plan,
            store=folder / "sweep",
            executor=None,
            workers=1,
            shard=(1, 1),
            skip_damaged=False,
            progress=None,
        ),
        "merge_sweeps": tried(
            hc.merge_sweeps, stores=[folder / "sweep"], into=folder / "all", skip_damaged=False
        ),
        "open_sweep": tried(hc.open_sweep, store=folder / "sweep", skip_damaged=False),
        "calibrate": tried(
            hc.calibrate,
            taper="forward-linear",
            rates=(0.001, 0.002),
            beads=20,
            window=(5, 15),
            progress=None,
        ),
        "scoreboard": tried(hc.scoreboard, theories=["hard-sphere"], progress=None),
        "Scoreboard.worst": tried(board.worst, quantity="velocity", first_bead=2),
        "Scoreboard.rms": tried(board.rms, quantity="velocity", first_bead=2),
        "Scoreboard.coverage": tried(
            lambda theory: board.coverage(theory, "paper"), theory="local-rate"
        ),
        "Scoreboard.table": tried(
            board.table, quantity="velocity", statistic="worst", by="group", first_bead=2
        ),
        "Scoreboard.outside": tried(board.outside, by="group"),
        "Scoreboard.rows": tried(board.rows, by="group"),
        "Scoreboard.as_dict": tried(board.as_dict, by="group"),
        "verify": tried(hc.verify, groups=["restitution"], progress=None),
    }


@pytest.fixture(scope="module")
def every_call(tmp_path_factory):
    return public_calls(tmp_path_factory.mktemp("public_calls"))


def public_names():
    """Names of all public functions, constructors and methods that take arguments."""
    for name in hc.__all__:
        item = getattr(hc, name)
        if inspect.isfunction(item) and inspect.signature(item).parameters:
            yield name
        if not inspect.isclass(item) or issubclass(item, Exception):
            continue
        if name not in RESULTS:
            yield name
        for method, function in inspect.getmembers(item, callable):
            if method.startswith("_") or method in INTERNAL:
                continue
            if set(inspect.signature(function).parameters) - {"self"}:
                yield f"{name}.{method}"


NAMES = sorted(public_names())


def test_every_public_function_is_called(every_call):
    assert set(NAMES) <= set(every_call)


def test_valid_arguments_are_accepted(every_call):
    for name, (function, good) in every_call.items():
        if not name.startswith(("load_chain", "load_d", "FitResult.sample", "warm_up")):
            expected = pytest.raises(hc.InputError) if name in NO_RESTITUTION else nullcontext()
            with expected:
                function(**good)


def default_of(function, argument):
    """Default value of an argument; the empty one of `inspect` without a default."""
    found = inspect.signature(function).parameters.get(argument)
    return inspect.Parameter.empty if found is None else found.default


def error_of(function, arguments):
    """Exception of a call, or None."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            function(**arguments)
    except Exception as error:  # noqa: BLE001
        return error
    return None


# Formulas with valid arguments, by their names in `hertzchain.theory`.
FORMULAS = {
    "backward_linear_prefactor": {"rate": 0.1},
    "band_edges": {"mass": 1.0, "other_mass": 2.0, "spring": 1.0},
    "bca_velocity_closed_form": {"taper": "backward-linear", "rate": 0.1, "beads": 9},
    "dispersion_diatomic": {"wave_number": 0.1, "mass": 1.0, "other_mass": 2.0, "spring": 1.0},
    "dispersion_uniform": {"wave_number": 0.1, "mass": 1.0, "spring": 1.0},
    "exponential_energy_ratio": {"q": 0.1, "beads": 4, "restitution": 1.0},
    "exponential_rates": {"taper": "backward-exponential", "rate": 0.1},
    "steady_rates": {"taper": "backward-exponential", "rate": 0.1},
    "forward_linear_momentum_slope": {"rate": 0.1},
    "hard_sphere_energy_ratio": {"chain": Chain.uniform(4), "restitution": 1.0},
    "linear_stiffness": {"stiffness": 1.0, "force": 1.0, "exponent": 1.5},
    "long_wave_speed_constant": {"exponent": 1.5},
    "long_wave_velocity": {"distance": 0.1, "exponent": 1.5},
    "modes": {"chain": Chain.uniform(4), "force": 1.0, "ends": ("free", "free")},
    "precompressed_speed": {"force_ratio": 2.0, "exponent": 1.5},
    "printed_correction": {"taper": "forward-linear"},
    "printed_velocity": {"taper": "forward-linear", "rate": 0.005, "k": [1.0, 2.0]},
    "restitution_from_unloading": {"loss": 0.1},
    "sen_manciu_coefficients": {"wave": hc.solitary_wave()},
    "sen_manciu_velocity": {"distance": 0.1, "coefficients": (1.0, 1.0, 1.0)},
    "spring_modes": {"masses": [1.0, 1.0], "springs": [1.0], "ends": (0.0, 0.0)},
    "two_thirds_bca": {"chain": Chain.uniform(4)},
}  # fmt: skip


@pytest.mark.parametrize("name", FORMULAS)
def test_invalid_arguments_of_formulas_raise_one_sentence(name):
    function, good = getattr(hc.theory, name), FORMULAS[name]
    function(**good)
    for argument, value in itertools.product(good, [*TRIED.values(), 0, -1.0]):
        error = error_of(function, good | {argument: value})
        never = value is None or (type(value) in (object, float) and value != -1.0)
        assert isinstance(error, hc.InputError) or (error is None and not never), (argument, error)
        assert "\n" not in str(error)


def test_every_formula_is_called():
    documented = [name for name in dir(hc.theory) if inspect.isfunction(getattr(hc.theory, name))]
    assert set(FORMULAS) <= set(documented)
    assert {name for name in documented if not name.startswith("_")} <= set(FORMULAS)


# A whole number is a possible row of a longer table, number of steps, or end of a count of waves.
POSSIBLE = {
    ("index", IndexError), ("max_steps", hc.SimulationError), ("until", hc.SimulationError),
}  # fmt: skip


@pytest.mark.parametrize("value", TRIED.values(), ids=TRIED)
def test_invalid_arguments_raise_one_sentence(every_call, value, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, (function, good) in every_call.items():
        for argument, usual in good.items():
            # Where None is the default, the call is valid, and may compute all that there is.
            if value is None and (usual is None or default_of(function, argument) is None):
                continue
            error = error_of(function, good | {argument: value})
            if isinstance(value, int) and (argument, type(error)) in POSSIBLE:
                continue
            if error is None:
                # Three of something may be right, and some text and lists; these two never.
                assert not isinstance(value, float), (name, argument)
                assert type(value) is not object, (name, argument)
                continue
            assert isinstance(error, hc.InputError), (name, argument, error)
            for trace in ("\n", "array(", "Traceback"):
                assert trace not in str(error), (name, argument, error)
