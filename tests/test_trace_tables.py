"""Tables of measured traces, and of their comparison with a run."""

import numpy as np

import hertzchain as hc


def test_tables_of_measured_traces_state_their_units():
    times = np.array([0.0, 1e-6, 2e-6])
    first = hc.Traces.from_arrays(
        times, {"wall [N]": [0, 5, 1], "ball 3 [V]": [0, 1, 0]}, noise=0.1
    )
    second = hc.Traces.from_arrays(times, {"wall [N]": [1.0, 3.0, np.nan]}, noise=0.1)
    table = (first + second).to_dataframe()
    assert list(table.columns) == ["shot", "time", "wall", "ball 3"]
    assert table.attrs["units"] == {"time": "s", "wall": "N", "ball 3": "V"}
    assert table.shot.tolist() == [1, 1, 1, 2, 2, 2]
    np.testing.assert_array_equal(table.wall, [0.0, 5.0, 1.0, 1.0, 3.0, np.nan])
    np.testing.assert_array_equal(table["ball 3"], [0.0, 1.0, 0.0, *[np.nan] * 3])


def test_tables_of_comparisons_state_the_units_of_times():
    traces, chain = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
    table = run.compare(traces).to_dataframe()
    times = ["measured_arrival", "simulated_arrival", "arrival_error", "delay"]
    times += ["measured_duration", "simulated_duration"]
    assert table.attrs["units"] == dict.fromkeys(times, "s")
    assert {*times, "unit"} < {*table.columns}
