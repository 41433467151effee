"""Numbers as a reader wants them: thousands separated, as many digits as carry meaning, the unit beside them."""

import math
from typing import Any

NO_REFERENCE = "no reference"
NOT_RECORDED = "not recorded"
NOT_MEASURED = "not measured"


def finite_number(value: Any) -> float | None:
    """The value as a float; None for null, text, booleans, NaN and infinities, which all mean "no answer" in a result file."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if math.isfinite(value) else None


def count_text(value: float) -> str:
    return f"{value:,.0f}"


def metres_text(value_m: float) -> str:
    return length_text(value_m, "m")


def length_text(value: float, unit: str) -> str:
    return f"{length_digits(value)} {unit}"


def length_digits(value: float) -> str:
    size = abs(value)
    if size == 0.0:
        return "0"
    decimals = 4 if size < 0.01 else 3 if size < 0.1 else 2 if size < 100.0 else 1
    return f"{value:,.{decimals}f}"


def percent_text(fraction: float) -> str:
    return f"{100.0 * fraction:.1f} %"


def seconds_text(value_s: float) -> str:
    size_s = abs(value_s)
    if size_s == 0.0:
        return "0 s"
    if size_s < 0.9995e-3:
        return f"{1e6 * value_s:.3g} µs"
    if size_s < 0.9995:
        return f"{1e3 * value_s:.3g} ms"
    return f"{value_s:.3g} s" if size_s < 100.0 else f"{value_s:,.0f} s"


def times_text(factor: float) -> str:
    """How many times as much: two significant digits below ten, whole numbers above; never powers of ten."""
    return f"{factor:.2g}" if abs(factor) < 9.95 else f"{factor:,.0f}"


def plain_text(value: float) -> str:
    """A dimensionless number: four significant digits, integers as they are."""
    if value == round(value) and abs(value) < 1e15:
        return f"{value:,.0f}"
    return f"{value:,.1f}" if abs(value) >= 1000.0 else f"{value:.4g}"
