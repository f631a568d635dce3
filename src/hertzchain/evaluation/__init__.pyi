from .cases import Case as Case
from .cases import paper_cases as paper_cases
from .cases import unseen_cases as unseen_cases
from .scoreboard_rows import percentage as percentage
from .unseen_tapers import is_smooth as is_smooth
from .unseen_tapers import unseen_radii as unseen_radii
