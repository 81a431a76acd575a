from . import addresses as addresses
from .assignments import (
    read_value as read_value,
    short_key as short_key,
    to_text as to_text,
    with_assignments as with_assignments,
    with_values as with_values,
)
from .checks import taken_in_results as taken_in_results
from .coordinates import (
    COORDINATES as COORDINATES,
    IN_CAPTIONS as IN_CAPTIONS,
    NUMERIC as NUMERIC,
    OF_FIGURES as OF_FIGURES,
    caption_form as caption_form,
    coordinates_of as coordinates_of,
    goes_unsaid as goes_unsaid,
    idle_caption as idle_caption,
    plural_of as plural_of,
    title_of as title_of,
)
from .fields import LARGEST as LARGEST
from .members import Member as Member, Members as Members
from .needs import unmet_needs as unmet_needs, warn_of_needs as warn_of_needs
from .precision import Until as Until
from .settings import (
    KEYS as KEYS,
    Schedule as Schedule,
    Setting as Setting,
    Swarm as Swarm,
    World as World,
    set_apart as set_apart,
    values_of as values_of,
)
from .study import Study as Study
from .tables import UNNAMED as UNNAMED, Measure as Measure
from .wanted import OPEN as OPEN, Wanted as Wanted, key_of as key_of, open_values as open_values
