from . import traces as traces
