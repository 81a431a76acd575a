from .choices import (
    BESIDE as BESIDE,
    KEYS as KEYS,
    MOST_CONNECTED as MOST_CONNECTED,
    MOST_ROBOTS as MOST_ROBOTS,
    PLAYED as PLAYED,
    first_view as first_view,
    offer_of as offer_of,
)
from .exporting import export as export
from .frame import Watching as Watching, watch as watch
from .interpreted import prepared as prepared
from .recordings import LoggedRecording as LoggedRecording
from .server import (
    LOOPBACK as LOOPBACK,
    Served as Served,
    bound as bound,
    listen as listen,
    serve as serve,
    serving as serving,
    warm as warm,
)
