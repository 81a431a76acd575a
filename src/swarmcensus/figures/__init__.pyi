from . import notebook as notebook, plot as plot
from .brain_colours import colours_of_brains as colours_of_brains
from .columns import columns_grid as columns_grid
from .files import caption_file as caption_file, save as save
from .groups import crosses_of as crosses_of, shares_of as shares_of
from .network_places import (
    MOST_LAID_OUT as MOST_LAID_OUT,
    edges_drawn as edges_drawn,
    in_a_row as in_a_row,
    places_of_robots as places_of_robots,
)
from .page import drawing as drawing
from .plan_lines import draw_plan as draw_plan
from .sheets import Scale as Scale
