"""Points of a sweep: values of parameters."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from . import _myxo

Point = dict[str, Any]


def grid(axes: Mapping[str, Iterable[Any]]) -> list[Point]:
    """Every combination of the values of each parameter; the last parameter changes fastest.

        myxo.grid({"physarum.sensor_angle": [15, 30], "trail.decay": [0.9, 0.95]})    # four points
    """
    for key, values in axes.items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise TypeError(f"the values of `{key}` are {values!r}: a list is needed")
    return [dict(zip(axes, values)) for values in itertools.product(*axes.values())]


def sample(
    ranges: Mapping[str, Sequence[float]], count: int, *, method: str = "latin", seed: int = 0
) -> list[Point]:
    """`count` points within ranges `(low, high)`, by a Latin hypercube (`latin`), Sobol's sequence (`sobol`) or at random (`random`);
    the same for the same seed. Parameters of whole numbers get whole numbers, both limits among
    them; points that come twice are left out. Latin and Sobol use SciPy.
    """
    import numpy as np

    if count < 1:
        raise ValueError(f"a sample has 1 point or more, not {count}")
    for key, limits in ranges.items():
        if len(limits) != 2 or not limits[0] < limits[1]:
            raise ValueError(f"the range of `{key}` is {limits!r}: (low, high) is needed, the first below the second")
    if method == "random":
        shares = np.random.default_rng(seed).random((count, len(ranges)))
    elif method in ("latin", "sobol"):
        from scipy.stats import qmc

        kind = qmc.LatinHypercube if method == "latin" else qmc.Sobol
        shares = kind(len(ranges), seed=seed).random(count)
    else:
        raise ValueError(f"there is no way of sampling `{method}`: latin, sobol or random")
    points = [{key: _within(key, limits, share) for (key, limits), share in zip(ranges.items(), row)} for row in shares]
    # Of few whole numbers some come twice.
    return list({tuple(point.values()): point for point in points}.values())


def _within(key: str, limits: Sequence[float], share: float) -> float:
    """The value of a parameter at a share of its range, from 0 to below 1. Each whole number has the same part of that."""
    low, high = limits
    if not _myxo.is_whole(key):
        return float(low + share * (high - low))
    low, high = math.ceil(low), math.floor(high)
    if low > high:
        raise ValueError(f"the range of `{key}` has no whole number")
    return min(high, low + int(share * (high - low + 1)))
