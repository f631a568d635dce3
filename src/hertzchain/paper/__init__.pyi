from .figures import draw_figure as draw_figure
from .figures import reproduce_figure as reproduce_figure
from .report import verdict as verdict
from .report import write_report as write_report
from .reproduction import Reproduction as Reproduction
from .reproduction import reproduce as reproduce
from .tables import reproduce_table as reproduce_table
