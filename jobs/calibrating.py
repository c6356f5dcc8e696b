# SPDX-License-Identifier: GPL-3.0-or-later
"""The command jobs/calibrate-release: the release speed with which cracks are as fast as measured, and its interval."""
from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
from crackle.units import quantity_of
from crackle_launch import environment
from crackle_runs import RunError, command, run, with_keys

N_DRAWS = 1000
FACTORS = (0.5, 0.7, 1, 1.4, 2)  # of the release speed by the formula for the speed of steady cracks
LEVELS = (2.5, 97.5)  # [%]


def quantity(text: str) -> tuple[float, str]:
    try:
        return quantity_of(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number with a unit, such as '450 m/s' or '0.2 us'") from None


def metres_per_second(text: str) -> float:
    speed, unit = quantity(text)
    if unit != "m/s":
        raise argparse.ArgumentTypeError(f"'{text}' is not a speed, such as '780 m/s'")
    return speed


def rounded(speed: float) -> str:
    return f"{float(f'{speed:.3g}'):g}"


def crossings(speeds: np.ndarray, values: np.ndarray, measured: float) -> list[float]:
    """Release speeds at which the mean of the results, linear over the logarithm between those computed, is the measured value."""
    difference, log = values - measured, np.log(speeds)
    return [float(np.exp(log[i] + (log[i + 1] - log[i]) * difference[i] / (difference[i] - difference[i + 1])))
            for i in range(len(speeds) - 1) if difference[i] * difference[i + 1] <= 0 and difference[i] != difference[i + 1]]


def release_speed(speeds: np.ndarray, results: np.ndarray, measured: float, error: float) -> tuple[float, float, float]:
    """Release speed and its 95 % interval [m/s]; NaN where it lies beyond the speeds computed.

    Meshes are drawn anew (all results of one sample together), and the measured value within its error. Where the means are not
    monotone the highest speed counts.

    @param results: of each speed and sample, shape (speeds, samples)
    """
    random = np.random.Generator(np.random.Philox(1))
    n_samples = results.shape[1]
    draws = [(results[:, random.integers(n_samples, size=n_samples)].mean(axis=1), random.normal(measured, error)) for _ in range(N_DRAWS)]
    found = [crossings(speeds, means, value) for means, value in draws]
    best, mean = crossings(speeds, results.mean(axis=1), measured), results.mean(axis=1)
    # Beyond either end of the speeds the draw still counts, as lower or higher than all.
    falls = mean[0] > mean[-1]
    speeds_found = [some[-1] if some else (0.0 if (value > means.max()) == falls else np.inf) for some, (means, value) in zip(found, draws)]
    low, high = np.percentile(speeds_found, LEVELS, method="nearest")
    return (best[-1] if best else np.nan), *(end if 0 < end < np.inf else np.nan for end in (low, high))


def speed_by_formula(arguments: argparse.Namespace) -> float:
    """The release speed at which the program expects cracks as fast as measured, or the usual one for another result [m/s]."""
    is_speed = arguments.result == "crack_speed_max"
    options = ["--crack-speed", f"{arguments.measured[0]} m/s"] if is_speed else []
    done = subprocess.run([str(arguments.program), "check", "--no-measure", *options, str(arguments.input)],
                          capture_output=True, text=True, env=environment(), check=False)
    if done.returncode != 0:
        raise RunError(done.stderr.strip())
    found = re.search(r'take release_speed = "([\d.e+]+) m/s"' if is_speed else r"(?m)^release speed.*? ([\d.e+]+) m/s", done.stdout)
    if found is None:
        raise RunError(f"{arguments.input}: has no release speed from which to start; give --speeds")
    return float(found[1])


def draw(path: Path, title: str, speeds: np.ndarray, results: np.ndarray, measured: float, error: float,
         found: tuple[float, float, float]) -> None:
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullLocator
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.axhspan(measured - 1.96 * error, measured + 1.96 * error, color="0.88", label="measured, 95 %")
    axes.plot(speeds, results, ".", color="0.6", ms=4)
    axes.plot(speeds, results.mean(axis=1), "o-", color="C0", label="mean of the samples")
    for speed, style in zip(found, ("-", ":", ":")):
        if np.isfinite(speed):
            axes.axvline(speed, color="C3", ls=style)
    axes.set(xscale="log", xlim=(0.7 * speeds[0], 1.4 * speeds[-1]), xlabel="release speed [m/s]", ylabel=title)
    axes.set_xticks(speeds, [rounded(speed) for speed in speeds])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.legend()
    figure.savefig(path, dpi=130)


def input_text(arguments: argparse.Namespace) -> str:
    """The input; all that can be seen to be wrong before hours of computing is."""
    speeds = arguments.speeds
    reasons = {"--speeds: give two or more, above zero": speeds is not None and (min(speeds) <= 0 or len(set(speeds)) < 2),
               "--error must not be negative": arguments.error[0] < 0,
               "--error: give it in the unit of --measured": arguments.error[1] != arguments.measured[1],
               "--samples: three or more are needed": arguments.samples is not None and arguments.samples < 3}
    for reason, is_given in reasons.items():
        if is_given:
            raise RunError(reason)
    try:
        text = arguments.input.read_text()
        tables = tomllib.loads(text).keys()
    except (OSError, ValueError) as error:
        raise RunError(f"{arguments.input}: {error}") from None
    if "sweep" in tables or not {"ensemble", "fracture"} <= tables:
        raise RunError(f"{arguments.input}: an input with [ensemble] and [fracture] and without [[sweep]] is needed")
    return text


def calibrate(arguments: argparse.Namespace) -> int:
    text, columns, unit = input_text(arguments), [], ""
    (measured, measured_unit), (error, _) = arguments.measured, arguments.error
    start = speed_by_formula(arguments) if arguments.speeds is None else 0
    speeds = np.array(sorted(set(arguments.speeds or [float(rounded(factor * start)) for factor in FACTORS])))
    for speed in (np.inf, *speeds):
        is_immediate = np.isinf(speed)
        keys = {"fracture.release_time": '"0 s"' if is_immediate else None,
                "fracture.release_speed": None if is_immediate else f'"{speed:.6g} m/s"',
                **({"ensemble.samples": str(arguments.samples)} if arguments.samples is not None else {})}
        ensemble = run(with_keys(text, keys), arguments.output / ("immediate" if is_immediate else f"{speed:.6g}mps"), arguments.program,
                       ranks=arguments.ranks)
        if not np.issubdtype(ensemble.samples.get(arguments.result, np.array("")).dtype, np.number):
            raise RunError(f"no result '{arguments.result}' with numbers; `crackle stats --columns` lists all results")
        unit = ensemble.samples.attrs["units"].get(arguments.result, "")
        unit = "" if unit == "1" else unit
        if unit != measured_unit:
            raise RunError(f"--measured: '{arguments.result}' is {f'in {unit}' if unit else 'a pure number'}")
        columns.append(ensemble.samples[arguments.result].to_numpy(float))
        setting = "immediate release" if is_immediate else f"release speed {rounded(speed)} m/s"
        there = columns[-1][np.isfinite(columns[-1])]
        value = f"{there.mean():.4g} ± {there.std(ddof=1):.2g} {unit}".rstrip() if there.size > 1 else f"in {there.size} samples only"
        print(f"{setting}: {arguments.result} {value}", flush=True)
    results = np.array(columns)
    whole = np.isfinite(results).all(axis=0)
    if whole.sum() < 3:
        raise RunError(f"{whole.sum()} samples have a {arguments.result} at every release speed, and three are needed")
    if not whole.all():
        print(f"left out: {(~whole).sum()} of {whole.size} samples without a {arguments.result} at some release speed")
    found = release_speed(speeds, results[1:, whole], measured, error)
    draw(arguments.output / "calibration.png", f"{arguments.result} [{unit}]" if unit else arguments.result, speeds, results[1:, whole],
         measured, error, found)
    shown = [f"{rounded(speed)} m/s" if np.isfinite(speed) else beyond for speed, beyond in
             zip(found, ("", f"below {rounded(speeds[0])} m/s", f"above {rounded(speeds[-1])} m/s"))]
    if not shown[0]:
        print(f"no release speed between {rounded(speeds[0])} and {rounded(speeds[-1])} m/s gives {f'{measured:.4g} {unit}'.rstrip()}; "
              f"immediate release gives {results[0, whole].mean():.4g}; try other --speeds, or see whether load and toughness are the experiment's")
    else:
        print(f'release_speed = "{shown[0]}"  # 95 % interval {shown[1]} to {shown[2]}, on any spacing')
    print(arguments.output / "calibration.png")
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(prog="calibrate-release", description="Computes an input with several values of [fracture] release_speed and says "
                                     "with which of them a result, the crack's largest speed unless another is named, is as measured. The input "
                                     "should be the experiment's: its body, load, toughness. Finished runs are kept.")
    parser.add_argument("input", type=Path, metavar="INPUT.toml")
    parser.add_argument("--measured", type=quantity, required=True, help="the measured mean, with its unit: '450 m/s'")
    parser.add_argument("--error", type=quantity, required=True, help="its standard error, such as '20 m/s'")
    parser.add_argument("--result", default="crack_speed_max", help="a result of `crackle stats --columns` (%(default)s)")
    parser.add_argument("--speeds", type=metres_per_second, nargs="+", metavar="SPEED",
                        help="release speeds to compute (0.5 to 2 times that of a steady crack of this speed which is given twice its toughness, or "
                             "for another result than the speed, that of the input)")
    parser.add_argument("--samples", type=int, help="for each release speed (the input's number)")
    parser.add_argument("--ranks", type=int, default=1, help="of mpirun: a master and workers (1: without mpirun)")
    return command(parser, "calibrate-release", calibrate)


if __name__ == "__main__":
    sys.exit(main())
