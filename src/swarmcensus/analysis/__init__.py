"""What results say: `comparing` compares brains within each world, `explaining` compares measurements with theory.

In: a dataset.
Out: a `Comparison`, an `Explanation`, an `Agreement`.
Must not know: how trials were run, what is drawn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
