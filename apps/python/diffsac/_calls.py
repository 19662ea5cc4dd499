"""Calls of the library's functions, whose mistakes are one line that names the argument."""

import difflib
import functools
import inspect
import re
import warnings
from typing import Any, Callable, Dict, Iterable, Mapping, ParamSpec, Tuple, TypeVar

from ._former_names import KEYWORDS

# What `help` says of each argument; pixels may be any unit, the same for all of a call.
ARGUMENTS = {
    "x1": "N × 2, points of image 1 in pixels.",
    "x2": "N × 2, points of image 2: row i matches row i of x1.",
    "K1": "3 × 3, calibration matrix of image 1, without lens distortion.",
    "K2": "3 × 3, calibration matrix of image 2.",
    "points3d": "N × 3, points of the scene.",
    "points2d": "N × 2, their places in the image, in pixels.",
    "K": "3 × 3, calibration matrix of the image, without lens distortion.",
    "points": "N × 2 for lines, N × 3 for planes.",
    "points1": "N × 3, points of cloud 1.",
    "points2": "N × 3, points of cloud 2: row i matches row i of points1.",
    "segments": "N × 4: x1 y1 x2 y2, the ends of each segment, in pixels.",
    "snn_ratio": "N from 0 to 1: descriptor distance of the nearest neighbour / that of the second-nearest, lower is better. None: unknown.",
    "scores": "N from 0 to 1, higher is better: a matcher's confidences of all matches, instead of snn_ratio.",
    "size": "(width, height) of the image; needed without K.",
    "size1": "(width, height) of image 1.",
    "size2": "(width, height) of image 2.",
    "scale_rotation_changes": "N × 2: log(size2 / size1) and angle2 − angle1 in radians, of the keypoints of each match.",
    "principal_point1": "(x, y) of image 1. None: the centre of size1.",
    "principal_point2": "(x, y) of image 2. None: the centre of size2.",
    "prior": "(likeliest focal length in pixels, standard deviation of its logarithm). None: that of cameras in general.",
    "prior2": "The prior of the second camera. None: as prior.",
    "max_residual": "Inlier threshold in the unit of the points. None: 1 px, homographies 3, absolute poses 4; registration: twice the "
    "resolution of points2. Lines and planes need it.",
    "max_residual_deg": "Maximum angle between a segment and the direction to its vanishing point.",
    "least_value": "The list ends before the first vanishing point of lower probability, from 0 to 1. 0: eight.",
    "max_iterations": "Maximum number of minimal samples. None: the recommended one.",
    "min_iterations": "Minimum number of minimal samples. None: the recommended one.",
    "confidence": "Stops when a better model would have been sampled with this probability. None: 0.9999.",
    "num_threads": "Threads of this call, 0: one for each core. Results do not depend on it.",
    "initial_model": "A model of the result's shape to score in addition to the sampled ones.",
    "guidance": "'network', 'none' (PROSAC alone) or 'diffusion' (the paper's method).",
    "models_folder": "A folder of networks to use instead of the package's.",
    "cameras": "'photographs': one camera with square pixels, if sizes are given and equal; or 'unknown'.",
    "seed": "Seed of the random samples, 0 or more: the same seed, the same result.",
}
P = ParamSpec("P")
R = TypeVar("R")


def explained(function: Callable[P, R]) -> Callable[P, R]:
    """The same function of `_native`, with a signature that `inspect` knows: of arguments that do not fit, nanobind says in
    four lines what all are."""
    signature, doc = _declaration(function)

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        named = renamed(kwargs, signature.parameters)
        try:
            return function(*args, **named)
        except TypeError as error:
            raise _explanation(function.__name__, signature, args, named, error) from None

    call.__module__ = "diffsac"
    call.__doc__ = f"{doc}\n\n{described(signature.parameters)}"
    setattr(call, "__signature__", signature)
    return call


def renamed(kwargs: Mapping[str, Any], known: Iterable[str]) -> Dict[str, Any]:
    """The same arguments, those of 0.2 by their names of today, if these are among `known`, with a DeprecationWarning."""
    named = dict(kwargs)
    for old in [key for key in named if key in KEYWORDS and key not in known]:
        new, value_of = KEYWORDS[old]
        if new in known and new not in named:
            warnings.warn(f"{old} is {new} since diffsac 0.3", DeprecationWarning, stacklevel=3)
            named[new] = value_of(named.pop(old))
    return named


def described(names: Iterable[str]) -> str:
    return "\n".join(f"{name}: {ARGUMENTS[name]}" for name in names)


def _declaration(function: Any) -> Tuple[inspect.Signature, str]:
    # As nanobind makes stubs: "def name(x: type = \0, ...) -> type", with the defaults beside it.
    ((text, doc, defaults),) = function.__nb_signature__
    scope = {"defaults": defaults}
    exec("from __future__ import annotations\n" + re.sub(r"\\=?(\d+)", r"defaults[\1]", text) + ": ...", scope)
    return inspect.signature(scope[function.__name__]), doc


def _explanation(
    name: str, signature: inspect.Signature, args: Tuple[Any, ...], kwargs: Mapping[str, Any], error: TypeError
) -> Exception:
    known = signature.parameters
    for key in kwargs:
        if key not in known:
            nearest = difflib.get_close_matches(key, known, 1)
            end = f"did you mean '{nearest[0]}'?" if nearest else "there are " + ", ".join(known)
            return TypeError(f"{name}: no argument '{key}'; {end}")
    try:
        given = signature.bind(*args, **kwargs).arguments
    except TypeError as mistake:
        first = [key for key, parameter in known.items() if parameter.kind is not inspect.Parameter.KEYWORD_ONLY]
        end = f": {', '.join(first)}, and all others by name" if len(args) > len(first) else ""
        return TypeError(f"{name}: {mistake}{end}")
    for key, value in given.items():
        if value is None and known[key].default is not None:
            return ValueError(f"{key}: expected a value, got None")
    return TypeError(str(error).split("\n", 1)[0])
