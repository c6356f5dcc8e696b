# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of the paper's findings beside those of the campaign."""
from __future__ import annotations

import numpy as np

from crackle_report.photoelasticity import STRESS_OPTIC, WAVELENGTH
from crackle_runs import markdown

from .comparing import (DEVELOPED, binomial_test, in_base_frame, leading_notch, leading_path, needed, of_notch, reach,
                        running_half_width, share_interval)
from .fringes import FringeSeries
from .rows import Rows
from .tables import share, share_of, spread

TOLERANCE = 0.1e-3  # of the mean path [m]
SYMMETRIC = 0.6  # overlap of two cracks of about the same length


def quartiles(values: np.ndarray, digits: int) -> str:
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return f"median {middle:.{digits}f} (half of the samples {low:.{digits}f} to {high:.{digits}f})"


def _first_fork(rows: Rows) -> str:
    """Time, place, angle and speed of each sample's first fork in the projection: medians, and the middle half."""
    if not np.isfinite(rows.values["fork_time"]).any():
        return "none"

    def middle(name: str, unit: float, digits: int) -> str:
        values = rows.values[name][np.isfinite(rows.values[name])] / unit
        low, median, high = np.quantile(values, [0.25, 0.5, 0.75]) if len(values) else 3 * [np.nan]
        return f"{median:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"

    return (f"medians, and half of the samples: {middle('fork_time', 1e-6, 0)} µs after t₀, {middle('fork_place', 1e-3, 1)} mm from the notch, its arms "
            f"{middle('fork_angle', np.pi / 180, 0)}° apart, from a crack at {middle('fork_speed', 1, 2)} of Rayleigh's speed")


def _enough(rows: Rows) -> str:
    """How well this many samples tell the mean path and the shares."""
    n, path = len(rows), leading_path(rows)
    half_width = np.stack([running_half_width(column) for column in path.T], axis=1)
    enough = needed(half_width, TOLERANCE)
    shares = [f"{100 * low:.0f} to {100 * high:.0f} %" for low, high in
              (share_interval(rows.share(1), n), share_interval(int(rows.forked.sum()), n))]
    return (f"the leading crack's mean is known to ± {1e3 * half_width[-1].max():.3f} mm at the worst section (95 %, each by itself), "
            + (f"to ± {1e3 * TOLERANCE:g} mm at every section from {enough} samples on" if enough else f"not to ± {1e3 * TOLERANCE:g} mm")
            + f", the share of one crack to {shares[0]}, of forks to {shares[1]}")


def against_paper(rows: Rows, fringes: list[FringeSeries], own: Rows | None = None) -> str:
    """The paper's findings beside those of the campaign.

    @param own the same with mother points of each sample's own
    """
    n, values, lead = len(rows), rows.values, leading_notch(rows)
    one = values["pattern"] == 1
    first, second = int((lead[one] == 0).sum()), int((lead[one] == 1).sum())
    second_reach = reach(rows)[1]
    back = in_base_frame(rows, lead)
    leader = {name: of_notch(rows, name, lead) for name in ("kinks", "bend")}
    other = {name: of_notch(rows, name, np.where(lead < 0, -1, 1 - lead)) for name in ("kinks", "bend")}
    delay = 1e6 * np.abs(values["start_0"] - values["start_1"])
    delay = delay[np.isfinite(delay)]
    delays = f"{delay.min():.0f} to {delay.max():.0f} µs after the first, and" if len(delay) else "and"
    lines = [
        ["onset t₀", "76.179191 s at 5 N/s, the same for both samples shown",
         f"{quartiles(values['onset_time'], 1)} s, on a clock that starts at 135 N; depth and toughness were chosen for this"],
        ["groups", "simulations: symmetric crack paths; one crack from either notch. Experiments: one main crack from either notch; two, more "
         "or less anti-symmetric. Shares not given",
         f"one {share(rows.share(1), n)}; two {share(rows.share(2), n)}; other {rows.share(3)} of {n}. But the groups are not "
         f"apart: in {len(delay)} samples a second crack starts, {delays} crosses {spread(second_reach, '.2f')} of its ligament, in one hump. The "
         f"limit is at {DEVELOPED:g}; the notches' distance was chosen such that both groups occur. Two cracks of about the same "
         f"length (overlap above {SYMMETRIC:g}): {int((values['overlap'] > SYMMETRIC).sum())} of {n}"],
        ["when the paper's 100 µs are over", "not said",
         f"{int((values['outcome'] == 2).sum())} of {n} in two pieces"],
        ["notch that the single crack starts from", "either",
         f"lower {first}, upper {second}; p = {binomial_test(first, first + second):.2f} for equal chances. Half of the meshes, "
         f"drawn at random, are turned by 180 degrees; turned back, the lower one leads in {int((back == 0).sum())} of {n} (all "
         f"samples)"],
        ["bends and kinks", "seen",
         f"first crack: bent by {spread(np.degrees(np.abs(leader['bend'])), '.0f')}°, a kink in {int((leader['kinks'] > 0).sum())}; "
         f"second crack: {spread(np.degrees(np.abs(other['bend'])), '.0f')}°, a kink in {int((other['kinks'] > 0).sum())} of {n}"],
        ["bifurcation", "in 4 of the 8 samples shown, which are typical ones and no random choice",
         f"forks in the projection: {share_of(rows, 'bifurcations_projected')}; in space: {share_of(rows, 'bifurcations')}"],
        ["the first fork in the projection", "not given; Figure 6, \"Bifurcation\", has frames at t₀ + 30, 50 and 70 µs", _first_fork(rows)],
        ["largest crack speed / c_R", "not given",
         f"{spread(values['crack_speed_ratio'], '.2f')}; probably too fast, since the toughness does not grow with the speed (a [strip of "
         f"PMMA](../verification/README.md#the-strip-of-pmma), too, has larger speeds than measured)"],
    ]
    if fringes:
        start = np.array([one.roughness[0] for one in fringes])
        end = np.array([one.roughness[-1] for one in fringes])
        fallen = np.array([one.order[-1] / one.order[0] for one in fringes])
        alike = np.array([one.likeness for one in fringes])
        lines += [
            ["fringes before the cracks run", "like the experiment's",
             f"alike from sample to sample: correlation with the others' mean {alike[:, 0].min():.3f} or more ({len(fringes)} "
             f"of these bodies, with `verlet` and `auto`; there is no experiment to compare with)"],
            ["fringes afterwards", "blurred",
             f"after {1e6 * fringes[0].time[-1]:.0f} µs, away from cracks and notches, {np.median(end / start):.1f} times as rough "
             f"as at t₀, while the mean order has fallen to {np.median(fallen):.2f} of that at t₀; correlation {spread(alike[:, -1], '.2f')}, after "
             f"falling to {alike.mean(axis=0).min():.2f} on the way"]]
    lines += [
        ["samples", "200, by the convergence of the mean crack path",
         f"{n}; for this base distribution of mother points {_enough(rows)}"
         + (f". For the {len(own)} with a base each (`own`) {_enough(own)}" if own else "")],
        ["time", "not given", f"{np.median(values['forces']):.0f} force evaluations and {np.median(rows.seconds):.0f} s per sample "
                              f"(medians), {rows.seconds.sum() / 3600:.1f} hours on one core in all"],
        ["depth and distance of the notches", "not given", "2.5 mm; 6 mm between their mid-planes; chosen for onset and groups"],
        ["mesh", "1.0 mm on average at the top and bottom surfaces, two elements across a notch",
         "1 mm at most, 0.3 mm at the tips: two across a notch"],
        ["disturbance", "random; its size is not given", "0.2 spacings"],
        ["strength", "35 MPa", "31.8 MPa at 0.3 mm, and by the toughness of 60 J/m² elsewhere"],
        ["β, K_f, τ_f", "2, 1e-8 without unit, the time step",
         "2, 1e-8 MPa² s, all the time over the strength (`memory = \"cumulative\"`)"],
        ["stress-optic coefficient, wavelength", "not given",
         f"{STRESS_OPTIC:.2g} 1/Pa (typical of epoxy), {1e9 * WAVELENGTH:.0f} nm"],
    ]
    return markdown(["", "paper", "`crackle`"], lines)
