# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of the campaign besides its rows: ensemble.h5 itself, pictures of its report, fringes of its bodies."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from crackle_report.choosing import kinds, spread
from crackle_report.figures import convergence, crack_paths, crossings, growth, shares
from crackle_report.options import Options
from crackle_report.photoelasticity import Grid
from crackle_report.reading import read_ensemble
from crackle_report.results import Ensemble
from crackle_report.writing import write_light_figure, write_whole
from crackle_runs import RunError, markdown

from . import fringes
from .comparing import leading_notch
from .rows import Rows
from .running import done_samples

N_FRINGES = 40  # samples whose pictures are looked at
US = 1e-6
FIGURES = (((0.0, 40 * US, 70 * US, 100 * US), ((1, False), (1, True))),  # 5: one main crack path
           ((0.0, 30 * US, 50 * US, 70 * US), ((2, True), (1, True))))  # 6: bifurcation
"""The paper's figures of fringes: their times since the onset, and the kinds of sample that each shows, the best first; else any."""


def typical_eight(ensemble: Ensemble) -> list[int]:
    """Two samples of each kind, as Figure 3 has eight: one crack, two cracks, and the same with forks in the projection.

    The first of a kind is nearest to all others of it, the second differs most from the first.
    """
    found = kinds(ensemble)
    return [i for forked in (False, True) for pattern in (1, 2) for i in spread(ensemble, found.get((pattern, forked), []), 2)]


def keep_pictures(results: Path, folder: Path) -> None:
    """Typical paths, the report's pictures of all, and fringes and growth of a sample of each kind at the paper's times."""
    ensemble = read_ensemble(results)
    for name, picture in (("crossings", crossings), ("convergence", convergence), ("shares", shares)):
        write_light_figure(picture.section(ensemble, Options()).pictures[0].figure, folder / f"{name}.png")
    eight, found = typical_eight(ensemble), kinds(ensemble)
    grown = []
    for number, (times, groups) in enumerate(FIGURES, 1):
        group = next((found[kind] for kind in (*groups, *found) if kind in found), [])
        grown.append((number, times, tuple(spread(ensemble, group, 1))))
    shown = {*eight, *(sample for _, _, chosen in grown for sample in chosen)}
    if lacking := sorted(shown - ensemble.files.files.keys()):
        print(f"typical-paths.png and growth-*.png stay as they are: they show samples {', '.join(map(str, lacking))}, whose files "
              f"are not in {results}; crackle run --resume --samples computes them again")
        return
    if eight:
        write_light_figure(crack_paths.of(ensemble, eight), folder / "typical-paths.png")
    for number, times, chosen in grown:
        options = Options(samples=chosen, times=times, animation=False)
        if chosen and (section := growth.section(ensemble, options)):
            write_light_figure(section.pictures[0].figure, folder / f"growth-{number}.png")


def keep_ensemble(results: Path, folder: Path) -> None:
    """ensemble.h5, bit by bit, because it is sealed by a digest.

    @raise RunError: the one that is kept has samples that the new one lacks
    """
    found, kept = results / "ensemble.h5", folder / "ensemble.h5"
    if lacking := done_samples(kept) - done_samples(found):
        raise RunError(f"{kept} has {len(lacking)} samples that {found} lacks; jobs/paper/study campaign --known {folder} puts them in")
    write_whole(kept, found.read_bytes())


def keep_fringes(results: Path, rows: Rows, file: Path) -> None:
    """Looks at the pictures of the first samples that have files, unless the file has these, or more, of the same input."""
    wanted = rows.sample[:N_FRINGES].tolist()
    digest, known = fringes.contents(file) if file.is_file() else ("", [])
    if digest == rows.input and (len(known) > len(wanted) or known == wanted):
        return
    turned = set(rows.sample[leading_notch(rows) == 1].tolist())
    fringes.write_csv(fringes.look_through(read_ensemble(results), wanted, turned), rows.input, file)


def keep_laws(immediate: Path, softening: Path, folder: Path) -> str:
    """The same bodies with immediate release and with softening: their pictures at the paper's times, and a table of how rough
    the fringe order is, which is returned; empty where no body has both.
    """
    files = [read_ensemble(results) for results in (immediate, softening)]
    both = sorted(set.intersection(*(set(one.done.tolist()) & one.files.files.keys() for one in files)))
    if not both:
        return ""
    titles, times = ("immediate", "softening"), FIGURES[0][0]
    grid = Grid.over(*fringes.WINDOW, fringes.PIXEL)
    bodies = [(title, one.files.frames(both[0])) for title, one in zip(titles, files)]
    write_light_figure(fringes.side_by_side(bodies, times, grid), folder / "fringes-laws.png")
    lines = []
    for title, one in zip(titles, files):
        found = []
        for number in both:
            frames = one.files.frames(number)
            orders = fringes.orders(frames, one.plate.notch_tip, fringes.nearest(frames, times))
            scale = float(np.nanmean(orders[0]))
            found.append([fringes.roughness(order, scale) for order in orders])
        values = np.array(found)
        lines.append([title, str(len(both)), *(f"{column.mean():.4f} ± {column.std(ddof=1):.4f}" if len(both) > 1 else
                                               f"{column.mean():.4f}" for column in values.T),
                      f"{np.median(values[:, -1] / values[:, 0]):.1f}"])
    return markdown(["release", "samples", "roughness at t₀", *(f"after {time / US:.0f} µs" for time in times[1:]),
                     f"after {times[-1] / US:.0f} µs over t₀"], lines)
