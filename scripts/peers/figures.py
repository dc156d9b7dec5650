"""Numbers as tables show them."""

import math


def number(value, scale=1.0, digits=3):
    if value is None or math.isnan(value) or math.isinf(value):
        return "–"
    value *= scale
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{decimals}f}"
