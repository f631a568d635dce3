from .chain import TAPERS as TAPERS
from .chain import Chain as Chain
from .errors import InputError as InputError
from .errors import ModelRangeWarning as ModelRangeWarning
from .errors import SimulationError as SimulationError
from .propagation import propagate as propagate
from .propagation import propagate_many as propagate_many
from .pulse import Comparison as Comparison
from .pulse import Pulse as Pulse
from .pulse_table import PulseTable as PulseTable
from .simulation import Run as Run
from .simulation import simulate as simulate
from .store import load_chain as load_chain
from .theory.bca import bca as bca
from .theory.effective_chain import effective_chain as effective_chain
from .theory.hard_sphere import hard_sphere as hard_sphere
from .theory.local_rate import local_rate as local_rate
from .theory.local_rate import local_rate_gradient as local_rate_gradient
from .theory.modified_bca import modified_bca as modified_bca
from .theory.solitary_wave import SolitaryWave as SolitaryWave
from .theory.solitary_wave import solitary_wave as solitary_wave

__version__: str
