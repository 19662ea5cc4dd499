"""Calls of the library's functions, whose mistakes are one line that names the argument."""

import difflib
import functools
import inspect
import re
from typing import Any, Callable, Iterable, Mapping, ParamSpec, Tuple, TypeVar

# What `help` says of each argument; pixels may be any unit, the same for all of a call.
ARGUMENTS = {
    "x1": "N × 2, points of image 1 in pixels.",
    "x2": "N × 2, those of image 2: row i is the match of row i of x1.",
    "K1": "3 × 3, calibration matrix of image 1, without lens distortion.",
    "K2": "3 × 3, that of image 2.",
    "points3d": "N × 3, points of the scene.",
    "points2d": "N × 2, in pixels: where the image shows them.",
    "K": "3 × 3, calibration matrix of the image, without lens distortion.",
    "points": "N × 2 of lines, N × 3 of planes.",
    "points1": "N × 3, points of cloud 1.",
    "points2": "N × 3, those of cloud 2: row i is the match of row i of points1.",
    "segments": "N × 4: x1 y1 x2 y2, the ends of each segment, in pixels.",
    "ratio": "N from 0 to 1: distance of the nearest descriptor / that of the second-nearest, lower is better. None: unknown.",
    "scores": "N from 0 to 1, higher is better, of matchers that give some, of all matches: in the place of ratio.",
    "size": "(width, height) of the image; needed without K.",
    "size1": "(width, height) of image 1.",
    "size2": "(width, height) of image 2.",
    "similarities": "N × 2: log(size2 / size1) and angle2 − angle1 in radians, of the keypoints of each match.",
    "principal_point1": "(x, y) of image 1. None: the centre of size1.",
    "principal_point2": "(x, y) of image 2. None: the centre of size2.",
    "prior": "(likeliest focal length in pixels, standard deviation of its logarithm). None: that of cameras in general.",
    "prior2": "That of the second camera. None: as prior.",
    "max_residual_px": "Greatest residual of an inlier, in the unit of the points. 0: 1 px, homographies 3, absolute poses 4.",
    "max_residual_deg": "Greatest angle of a segment with the direction to its vanishing point.",
    "max_distance": "Greatest distance of an inlier, in the unit of the points. 0, of clouds alone: twice the resolution of points2.",
    "least_value": "The list ends before the first of which the network is less sure, from 0 to 1. 0: eight.",
    "max_iterations": "How many minimal samples are drawn at most. 0: what is recommended.",
    "use_network": "False: no network is read.",
    "models_folder": "Where networks are. None: DIFFSAC_MODELS, or those of the package.",
    "cameras": "Of F: photographs (square pixels, principal points near the middle, usual focal lengths) or unknown.",
    "seed": "Of the random draws, 0 or more: the same seed, the same result.",
}
P = ParamSpec("P")
R = TypeVar("R")


def explained(function: Callable[P, R]) -> Callable[P, R]:
    """The same function of `_native`, with a signature that `inspect` knows: of arguments that do not fit, nanobind says in
    four lines what all are."""
    signature, doc = _declaration(function)

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except TypeError as error:
            raise _explanation(function.__name__, signature, args, kwargs, error) from None

    call.__module__ = "diffsac"
    call.__doc__ = f"{doc}\n\n{described(signature.parameters)}"
    setattr(call, "__signature__", signature)
    return call


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
