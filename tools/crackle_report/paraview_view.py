# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens the files beside it in ParaView: the body coloured by its stress, its cracks by the time they opened, and its tools, all
moved by MAGNIFICATION times the displacement.

In ParaView: paraview --script=view.py. Without a screen: pvpython view.py PICTURE.png [FRAME], the last frame by default.
"""
import os
import sys

from paraview import simple

MAGNIFICATION = 10

folder = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
view = simple.GetActiveViewOrCreate("RenderView")
view.ViewSize = [1200, 900]
view.OrientationAxesVisibility = 0
view.UseColorPaletteForBackground = 0
view.Background = [1, 1, 1]


def moved_series(file):
    series = simple.OpenDataFile(os.path.join(folder, file))
    moved = simple.WarpByVector(Input=series, Vectors=["POINTS", "displacement"], ScaleFactor=MAGNIFICATION)
    return moved, simple.Show(moved, view)


def shown(kind, field, opacity, unit):
    moved, display = moved_series(f"{kind}.hdf.series")
    simple.ColorBy(display, ("CELLS", field))
    display.Opacity = opacity
    display.SetScalarBarVisibility(view, True)
    colours = simple.GetColorTransferFunction(field)
    colours.ApplyPreset("Viridis (matplotlib)", True)
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = f"{field} [{unit}]", ""
    bar.TitleColor = bar.LabelColor = [0, 0, 0]
    return moved, colours


body, stresses = shown("frame", "principal_stress", 0.3, "Pa")
_, opening = shown("crack", "time", 1.0, "s since the onset")
if os.path.exists(os.path.join(folder, "tools.hdf.series")):
    _, display = moved_series("tools.hdf.series")
    simple.ColorBy(display, None)
    display.Opacity, display.DiffuseColor = 0.3, [0.4, 0.4, 0.4]
simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
times = simple.GetTimeKeeper().TimestepValues
view.ViewTime = times[int(sys.argv[2]) if len(sys.argv) > 2 else -1]
body.UpdatePipeline(view.ViewTime)
stresses.RescaleTransferFunction(0, max(body.CellData["principal_stress"].GetRange()[1], 1))
opening.RescaleTransferFunction(0, max(times[-1], 1e-12))
view.CameraViewUp = [0, 0, 1]
view.CameraPosition, view.CameraFocalPoint = [1, 0, 0], [0, 0, 0]
view.ResetCamera()
simple.Render(view)
if len(sys.argv) > 1:
    simple.SaveScreenshot(sys.argv[1], view)
