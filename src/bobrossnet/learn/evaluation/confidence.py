"""Confidence intervals of means over several shapes.

Pictures of one shape are correlated, so errors are clustered by shape (Liang and Zeger, *Longitudinal data analysis
using generalized linear models*, 1986). With one picture of each shape they are the usual standard errors. Letters: P
pictures, F quantities measured on each picture.
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
    shapes : shape shown by each picture, (P,)

    Returns
    -------
    (F,), NaN for a single shape.
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
    """Return the ratio of two means minus 1, from pairs, with half of its 95 % confidence interval.

    Parameters
    ----------
    values, others : (P, F), in pairs
    shapes : shape shown by each picture, (P,)

    Returns
    -------
    (F, 2), NaN where the others' mean is 0; the half width is also NaN for a single shape.

    References
    ----------
    Cochran, *Sampling Techniques*, 1977: the ratio estimator and its variance by the delta method.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = values.mean(0) / others.mean(0)
        deviations = (values - ratio * others) / others.mean(0)
    return np.stack([ratio - 1, half_width(deviations, shapes)], 1)
