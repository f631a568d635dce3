"""The synthetic experiment that ships with hertzchain."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from ..traces.files import load_traces
from ..traces.traces import Traces
from ..validation.keywords import checked_arguments
from ..validation.objects import check_choice

FILES = {"fast": "fast.csv", "slow": "slow.csv"}


@checked_arguments("example_experiment")
def example_experiment(*shots: str) -> tuple[Traces, Path]:
    """Traces and chain file of a synthetic experiment, an example for `hertzchain.fit`.

    A row of 20 steel balls of 10 mm diameter in front of a steel wall is struck by an equal ball,
    at 0.3 m/s (``"fast"``) or 0.1 m/s (``"slow"``).  Sensors are in balls 6, 11 and 16 and in the
    wall; the one in ball 11 is not calibrated.  The data were computed with SciPy
    (``tools/example_traces.py``), with lag, discharge and crosstalk of the sensors.

    Parameters
    ----------
    *shots : str
        ``"fast"``, ``"slow"`` or both, in the order of the shots; by default ``"fast"``.

    Returns
    -------
    traces : Traces
        The data.
    chain_file : pathlib.Path
        The chain file, with a table ``[fit]``.

    Raises
    ------
    InputError
        For another name of a shot.

    Examples
    --------
    >>> import hertzchain as hc
    >>> traces, chain_file = hc.example_experiment()
    >>> traces.names
    ('ball 6', 'ball 11', 'ball 16', 'wall')
    """
    for each in shots:
        check_choice("shot of the example", each, FILES)
    folder = Path(str(files("hertzchain.fitting") / "example"))
    return load_traces(
        *(folder / FILES[each] for each in shots or ("fast",))
    ), folder / "experiment.toml"
