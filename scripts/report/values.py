"""Numbers with their intervals as tables show them."""
import math

from tables import UNKNOWN

FORMATS = {"value": ("{:.3f}", "{:.3f}"), "difference": ("{:+.3f}", "{:+.3f}"), "ms": ("{:.3g} ms", "{:.3g}"), "ratio": ("×{:.3g}", "{:.3g}")}


def known(value):
    return value is not None and not math.isnan(value)


def fixed(value, digits):
    """Formats with a fixed number of digits, values from 1e9 on as "1.5e+300"."""
    if not known(value):
        return UNKNOWN
    return f"{value:.{digits}f}" if abs(value) < 1e9 else f"{value:.3g}"


def range_text(interval, digits):
    """Formats an interval as "[0.450, 0.570]", empty if unknown."""
    return f"[{fixed(interval['low'], digits)}, {fixed(interval['high'], digits)}]" if interval and known(interval["low"]) else ""


def interval_text(interval, kind):
    """interval: {mean, low, high} or nothing."""
    if not interval or not known(interval["mean"]):
        return UNKNOWN
    value, end = FORMATS[kind]
    text = value.format(interval["mean"])
    return text if not known(interval["low"]) else f"{text} [{end.format(interval['low'])}, {end.format(interval['high'])}]"


def certain(interval, kind):
    """Whether a difference leaves 0 out, or a ratio 1."""
    if kind not in ("difference", "ratio") or not interval or not known(interval["low"]):
        return False
    none = 1 if kind == "ratio" else 0
    return interval["low"] > none or interval["high"] < none
