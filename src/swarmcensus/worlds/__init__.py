"""The world of a swarm: sensors, networks, floors, bodies, arenas and faults; parsed, validated and drawn here.

In: values of a study's tables, addresses of random numbers.
Out: arrays of accuracies, links, colours and faults; the robustness of networks.
Must not know: brains, studies, settings, what is measured.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
