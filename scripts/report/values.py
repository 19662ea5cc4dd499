"""Numbers with their intervals as tables show them, and the paired bootstrap."""
import math

from tables import UNKNOWN

FORMATS = {"value": ("{:.3f}", "{:.3f}"), "difference": ("{:+.3f}", "{:+.3f}"), "ms": ("{:.3g} ms", "{:.3g}"), "ratio": ("×{:.3g}", "{:.3g}")}


def known(value):
    return value is not None and not math.isnan(value)


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


def bootstrap(scenes, rounds=1000):
    """The mean over scenes of their means, with its 95 % interval: problems are redrawn within their scene, always alike."""
    import numpy

    scenes = [numpy.asarray(scene, float) for scene in scenes]
    rng = numpy.random.default_rng(0)
    means = sum(rng.choice(scene, (rounds, len(scene))).mean(1) for scene in scenes) / len(scenes)
    low, high = numpy.quantile(means, [0.025, 0.975])
    return {"mean": float(numpy.mean([scene.mean() for scene in scenes])), "low": float(low), "high": float(high)}
