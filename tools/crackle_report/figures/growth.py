# SPDX-License-Identifier: GPL-3.0-or-later
"""Photo-elastic fringes and crack growth over time, as in the paper's Figures 5 and 6."""
from __future__ import annotations

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure
from PIL import Image

from .. import style
from ..choosing import samples_in_detail
from ..drawing import Sheet, draw_borders, draw_facets, draw_plate, draw_regions, draw_tools, panel_size, time_bar, time_colours
from ..mesh import Mesh, Regions
from ..options import Options
from ..photoelasticity import NO_FRINGES, STRESS_OPTIC, Grid, make_series
from ..fields import CrackSurface, Frames
from ..results import Ensemble
from ..stress import frame_stresses
from .picture import Animation, Picture, Section

N_TIMES = 6
PIXELS_ACROSS, PIXELS_ALONG = 245, 1400  # at most, over the width of the plate and the length that is shown
PANEL_ROOM, MOST_HEIGHT, TITLE_ROOM = 2.2, 7.0, 0.85  # [inch]: a panel's width and height at most, what its title takes
N_COLOURS = 256  # of an animation
FRAME_SECONDS, LAST_SECONDS = 0.35, 2.0
ANIMATION_WIDTH, ANIMATION_DPI = 4.6, 110  # [inch]


def section(ensemble: Ensemble, options: Options) -> Section | None:
    views = []
    for number in options.samples or samples_in_detail(ensemble):
        frames, crack = ensemble.files.frames(number), ensemble.files.crack(number)
        if frames is not None and crack is not None and frames.time.size:
            views.append(_View(ensemble, number, frames, crack, options))
    if not views:
        return None
    result = Section("Fringes and crack growth" if views[0].optics else "Crack growth", _explain(views[0], options) + ensemble.tinted)
    for view in views:
        result.pictures.append(Picture(f"growth-{view.number:04d}", f"{result.title} of sample {view.number}", view.rows(options.times)))
        if options.animation and view.n_frames > 1:
            result.animations.append(view.animation())
    return result


def _explain(view: "_View", options: Options) -> str:
    growth = "The cracks that have opened by then; t₀ is the start of the last dynamic phase."
    if view.has_tools:
        growth += " Dashed: the tools, seen through the plate."
    if view.optics is None:
        return growth + (f" Fringes are not drawn: {NO_FRINGES}." if options.fringes else "")
    field = "light" if options.light_field else "dark"
    rule = ("the product of the Jones matrices along each ray" if options.product else
           "the integrated stress along each ray")
    return (f"Above, what a circular polariscope would show ({field} field{', colours reversed' * options.reverse}), by {rule}; "
            f"wavelength {options.wavelength * 1e9:g} nm, {_coefficient(options)}. Broken tetrahedra show the stress that they "
            f"still carry: none, or that of uncut edges and of contact.{view.unknown_note} Below: {growth[0].lower() + growth[1:]}")


def _coefficient(options: Options) -> str:
    if options.stress_optic:
        return f"stress-optic coefficient {', '.join(f'{value:.3g}' for value in options.stress_optic)} 1/Pa"
    return (f"stress-optic coefficient assumed: {STRESS_OPTIC:.3g} 1/Pa, typical of epoxy (that of PMMA is some ten times smaller and "
            "of the other sign; --stress-optic sets it)")


def _chosen_frames(frames: Frames, crack: CrackSurface, times: tuple[float, ...]) -> list[int]:
    """The frames nearest to the given times; without any, evenly from the onset to just after the last break."""
    if not times:
        last = int(np.searchsorted(frames.time, crack.last_opening))
        last = min(max(last, 1), frames.time.size - 1)
        times = tuple(np.linspace(0, frames.time[last], N_TIMES))
    return sorted({int(np.abs(frames.time - time).argmin()) for time in times})


def _palette() -> Image.Image:
    """The colours of an animation: greys, times and the plate's; white is the last one."""
    plate = [to_rgb(colour) for colour in (style.BODY, style.OUTLINE, style.BEFORE_ONSET, "white")]
    colours = np.vstack([np.linspace(0, 1, 120)[:, None].repeat(3, axis=1),
                         style.TIME_COLOURS(np.linspace(0, 1, 132))[:, :3], plate])
    image = Image.new("P", (1, 1))
    image.putpalette(np.round(255 * colours).astype(np.uint8).tobytes())
    return image


def _to_palette(image: Image.Image) -> Image.Image:
    result = image.quantize(palette=_palette(), dither=Image.Dither.NONE)
    # Pillow looks for near colours, not the nearest one, and paper should stay white.
    white = (np.asarray(image) == 255).all(axis=2)
    result.paste(N_COLOURS - 1, mask=Image.fromarray(np.uint8(255) * white))
    return result


class _View:
    """One sample's cracks round the notches, and its fringes where they are wanted."""

    def __init__(self, ensemble: Ensemble, number: int, frames: Frames, crack: CrackSurface, options: Options):
        self.number, self.optics = number, options.optics(frames)
        self._plate, self._frames, self._crack = ensemble.files.plate(number) or ensemble.plate, frames, crack
        self._regions = ensemble.files.regions(number)
        self._tools = ensemble.files.tools(number)
        self._onset = float(ensemble.samples.onset_time[number])
        left, right = ensemble.plate.ends(1)
        self._z = self._shown_length(ensemble.shown_z(crack))
        pixel = max((right - left) / PIXELS_ACROSS, (self._z[1] - self._z[0]) / PIXELS_ALONG)
        self._grid = Grid.over((left, right), self._z, pixel)
        self._lengths, self._times = ensemble.plate.lengths, ensemble.times
        self._colours = time_colours(crack.last_opening, self._times)
        self._options = options
        self._draws = [self._draw_fringes, self._draw_cracks] if self.optics else [self._draw_cracks]
        if self.optics:
            self._fringes = make_series(frames.nodes, frames.tetrahedra, frame_stresses(frames), self._grid, self.optics)
            is_unknown = np.broadcast_to(self.optics.stress_optic == 0, len(frames.tetrahedra))
            self._unknown = Regions(Mesh(frames.nodes, frames.tetrahedra[is_unknown]).cut(0, self._plate.size[0] / 2)[0], np.empty((0, 2, 2)))

    @property
    def has_tools(self) -> bool:
        return bool(self._tools)

    @property
    def n_frames(self) -> int:
        return self._frames.time.size

    @property
    def unknown_note(self) -> str:
        return " Materials stiffer than 10 GPa show no fringes, as their coefficient is not known." if self._unknown.polygons else ""

    def _shown_length(self, z: np.ndarray) -> tuple[float, float]:
        """The range of z [m] round all notches and cracks, stray breaks far away left out. @param z of the cracks' facets"""
        width = self._plate.size[1]
        bottom, top = self._plate.ends(2)
        ends = [end + side * 0.6 * width for low_and_high in self._plate.notch_slot[:, 1]
                for end, side in zip(low_and_high, (-1, 1))]
        if z.size:
            low, high = np.percentile(z, (2, 98))
            ends += [float(low) - 0.2 * width, float(high) + 0.2 * width]
        ends = ends or [bottom, top]
        return max(bottom, min(ends)), min(top, max(ends))

    def rows(self, times: tuple[float, ...]) -> Figure:
        """Fringes above, cracks below, or cracks alone; a column for each of these times, or for times that suit the growth."""
        chosen = _chosen_frames(self._frames, self._crack, times)
        n_rows = len(self._draws)
        n_columns = len(chosen)
        left, right, top, bottom, gap_x, gap_y = 0.55, 0.1, 0.85, 0.45, 0.12, 0.12
        room = min((style.PAGE_WIDTH - left - right - (n_columns - 1) * gap_x) / n_columns, PANEL_ROOM)
        panel_width, panel_height = self._panel_size(room)
        gap_x = max(gap_x, TITLE_ROOM - panel_width)
        figure = Sheet((panel_width, panel_height), n_rows, n_columns, (left, right, top, bottom), (gap_x, gap_y), 5.2)
        width, height = figure.get_size_inches()
        for k, frame in enumerate(chosen):
            for row, draw in enumerate(self._draws):
                axes = figure.panel(row, k)
                draw(axes, frame)
                axes.tick_params(left=k == 0, labelleft=k == 0, bottom=row == n_rows - 1, labelbottom=row == n_rows - 1)
                if k == 0:
                    axes.set_ylabel(self._lengths.label("z"))
                if row == n_rows - 1:
                    axes.set_xlabel(self._lengths.label("y"))
                if row == 0:
                    axes.set_title(self._time_text(frame), pad=4)
        time_bar(figure, self._colours, left, 2.0, self._times)
        figure.text((left + 2.3) / width, 1 - 0.22 / height, f"sample {self.number}", fontweight="bold", fontsize=9)
        if np.isfinite(self._onset):
            figure.text((left + 3.3) / width, 1 - 0.22 / height, f"t₀ = {self._onset:.4g} s", fontsize=8)
        return figure

    def animation(self) -> Animation:
        """Fringes and cracks side by side, or cracks alone, frame by frame."""
        left, bottom, gap, top = 0.55, 0.42, 0.15, 0.38
        panel = self._panel_size((ANIMATION_WIDTH - left - gap - 0.1) / 2)
        images = []
        for frame in range(self._frames.time.size):
            figure = Sheet(panel, 1, len(self._draws), (left, 0.1, top, bottom), (gap, 0.0), 3.0, dpi=ANIMATION_DPI)
            width, height = figure.get_size_inches()
            for k, draw in enumerate(self._draws):
                axes = figure.panel(0, k)
                draw(axes, frame)
                axes.tick_params(left=k == 0, labelleft=k == 0)
                axes.set_xlabel(self._lengths.label("y"))
                if k == 0:
                    axes.set_ylabel(self._lengths.label("z"))
            figure.text(left / width, 1 - 0.25 / height, f"sample {self.number}", fontweight="bold", fontsize=9)
            figure.text((left + 1.2) / width, 1 - 0.25 / height, self._time_text(frame), fontsize=9)
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3]))
        images = [_to_palette(image) for image in images]
        durations = [round(1000 * FRAME_SECONDS)] * (len(images) - 1) + [round(1000 * LAST_SECONDS)]
        what = "Fringes and cracks" if self.optics else "Cracks"
        gif = io.BytesIO()
        images[0].save(gif, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0)
        return Animation(f"growth-{self.number:04d}", f"{what} of sample {self.number} over time",
                         gif.getvalue(), images[0].width)

    def _panel_size(self, room: float) -> tuple[float, float]:
        return panel_size(self._plate, tuple(map(self._lengths.of, self._z)), room, MOST_HEIGHT)

    def _time_text(self, frame: int) -> str:
        time = self._times.of(self._frames.time[frame])
        return "t = t₀" if time == 0 else f"t = t₀ + {time:.0f} {self._times.name}"

    def _draw_fringes(self, axes: Axes, frame: int) -> None:
        options = self._options
        image = self._fringes[frame].intensity(options.light_field, options.product, options.reverse)
        low, high = map(self._lengths.of, self._z)
        self._draw_frame(axes)
        axes.imshow(image, cmap="gray", norm=Normalize(0, 1), origin="lower", interpolation="nearest", zorder=1,
                    extent=(*map(self._lengths.of, self._plate.ends(1)), low, high))
        draw_regions(axes, self._unknown, self._lengths, above=1)
        if self._regions is not None:
            draw_borders(axes, self._regions, self._lengths, above=1)

    def _draw_cracks(self, axes: Axes, frame: int) -> None:
        self._draw_frame(axes)
        draw_facets(axes, self._crack, self._colours, until=float(self._frames.time[frame]), lengths=self._lengths,
                    times=self._times)
        draw_tools(axes, self._tools, float(self._frames.time[frame]), self._lengths)

    def _draw_frame(self, axes: Axes) -> None:
        draw_plate(axes, self._plate, tuple(map(self._lengths.of, self._z)), regions=self._regions)
