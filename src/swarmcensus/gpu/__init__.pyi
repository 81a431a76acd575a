from . import choosing as choosing, driver as driver
from .cards import Card as Card, why_not as why_not
from .choosing import check_brains as check_brains, pays_off as pays_off
from .driver import (
    CardError as CardError,
    CardFull as CardFull,
    CardLost as CardLost,
    open_driver as open_driver,
)
from .examining import examine as examine
