from . import report as report, reproducing as reproducing
