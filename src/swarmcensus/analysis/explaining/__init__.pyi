from . import one_setting as one_setting
