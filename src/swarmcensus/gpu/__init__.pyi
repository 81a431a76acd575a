from . import driver as driver, paying as paying
from .cards import Card as Card, why_not as why_not
from .driver import (
    Buffer as Buffer,
    CardError as CardError,
    CardFull as CardFull,
    CardLost as CardLost,
    Driver as Driver,
    Program as Program,
    open_driver as open_driver,
)
from .paying import pays_off as pays_off
