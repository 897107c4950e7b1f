"""Confidence intervals of what was measured on several shapes.

Pictures of one shape are not independent of each other: errors are those of data in clusters, here shapes (Liang and
Zeger, *Longitudinal data analysis using generalized linear models*, 1986). With one picture of each they are the usual
ones. Letters: P pictures, F whatever is measured of each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]


def half_width(deviations: F64, shapes: Sequence[str]) -> F64:
    """Return half of the 95 % confidence interval of a mean.

    Parameters
    ----------
    deviations : (P, F), from the mean
    shapes : of each picture what it shows, (P,)

    Returns
    -------
    (F,), NaN if there is but one shape.
    """
    from scipy.special import stdtrit

    names, cluster = np.unique(shapes, return_inverse=True)
    count = len(names)
    if count < 2:
        return np.full(deviations.shape[1], np.nan)
    sums = np.zeros((count, deviations.shape[1]))
    np.add.at(sums, cluster, deviations)
    error = np.sqrt(count / (count - 1) * (sums**2).sum(0)) / len(deviations)
    return np.asarray(stdtrit(count - 1, 0.975) * error)  # Student's t


def relative_change(values: F64, others: F64, shapes: Sequence[str]) -> F64:
    """Return the ratio of two means less 1, from pairs, with half of its 95 % confidence interval.

    Parameters
    ----------
    values, others : (P, F), in pairs
    shapes : of each picture what it shows, (P,)

    Returns
    -------
    (F, 2), NaN where the others' mean is 0; the second also if there is but one shape.

    References
    ----------
    Cochran, *Sampling Techniques*, 1977: the ratio estimator and its variance by the delta method.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = values.mean(0) / others.mean(0)
        deviations = (values - ratio * others) / others.mean(0)
    return np.stack([ratio - 1, half_width(deviations, shapes)], 1)
