"""Calls of the library's functions, whose mistakes are one line that names the argument."""

import difflib
import functools
import inspect
import re
from typing import Any, Callable, Mapping, ParamSpec, Tuple, TypeVar

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
    call.__doc__ = doc
    setattr(call, "__signature__", signature)
    return call


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
