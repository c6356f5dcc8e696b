# SPDX-License-Identifier: GPL-3.0-or-later
"""The command jobs/calibrate-release: the release time with which cracks are as fast as measured, and its interval."""
from __future__ import annotations

import argparse
import sys
import tomllib
from pathlib import Path

import numpy as np
from crackle.units import quantity_of
from crackle_runs import RunError, command, run, with_keys

N_DRAWS = 1000
LEVELS = (2.5, 97.5)  # [%]


def quantity(text: str) -> tuple[float, str]:
    try:
        return quantity_of(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number with a unit, such as '450 m/s' or '0.2 us'") from None


def seconds(text: str) -> float:
    time, unit = quantity(text)
    if unit != "s":
        raise argparse.ArgumentTypeError(f"'{text}' is not a time, such as '0.2 us'")
    return time


def crossings(times: np.ndarray, values: np.ndarray, measured: float) -> list[float]:
    """Release times at which the mean of the results, linear over the logarithm between the times computed, is the measured value."""
    difference, log = values - measured, np.log(times)
    return [float(np.exp(log[i] + (log[i + 1] - log[i]) * difference[i] / (difference[i] - difference[i + 1])))
            for i in range(len(times) - 1) if difference[i] * difference[i + 1] <= 0 and difference[i] != difference[i + 1]]


def release_time(times: np.ndarray, results: np.ndarray, measured: float, error: float) -> tuple[float, float, float]:
    """Release time and its 95 % interval [s]; NaN where it lies beyond the times computed.

    Meshes are drawn anew (all results of one sample together), and the measured value within its error. Where the means are not
    monotone the shortest time counts.

    @param results: of each time and sample, shape (times, samples)
    """
    random = np.random.Generator(np.random.Philox(1))
    n_samples = results.shape[1]
    draws = [(results[:, random.integers(n_samples, size=n_samples)].mean(axis=1), random.normal(measured, error)) for _ in range(N_DRAWS)]
    found = [crossings(times, means, value) for means, value in draws]
    best, mean = crossings(times, results.mean(axis=1), measured), results.mean(axis=1)
    # Beyond either end of the times the draw still counts, as shorter or longer than all.
    falls = mean[0] > mean[-1]
    times_found = [some[0] if some else (0.0 if (value > means.max()) == falls else np.inf) for some, (means, value) in zip(found, draws)]
    low, high = np.percentile(times_found, LEVELS, method="nearest")
    return (best[0] if best else np.nan), *(end if 0 < end < np.inf else np.nan for end in (low, high))


def draw(path: Path, title: str, times: np.ndarray, results: np.ndarray, measured: float, error: float,
         found: tuple[float, float, float]) -> None:
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullLocator
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.axhspan(measured - 1.96 * error, measured + 1.96 * error, color="0.88", label="measured, 95 %")
    axes.plot(1e6 * times, results, ".", color="0.6", ms=4)
    axes.plot(1e6 * times, results.mean(axis=1), "o-", color="C0", label="mean of the samples")
    for time, style in zip(found, ("-", ":", ":")):
        if np.isfinite(time):
            axes.axvline(1e6 * time, color="C3", ls=style)
    axes.set(xscale="log", xlim=(7e5 * times[0], 1.4e6 * times[-1]), xlabel="release time [µs]", ylabel=title)
    axes.set_xticks(1e6 * times, [f"{1e6 * time:.3g}" for time in times])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.legend()
    figure.savefig(path, dpi=130)


def input_text(arguments: argparse.Namespace) -> str:
    """The input; all that can be seen to be wrong before hours of computing is."""
    reasons = {"--times: give two or more, above zero": min(arguments.times) <= 0 or len(set(arguments.times)) < 2,
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
    times = np.array(sorted(set(arguments.times)))
    for time in (0.0, *times):
        keys = {"fracture.release_time": f'"{1e6 * time:.6g} us"' if time else None,
                **({"ensemble.samples": str(arguments.samples)} if arguments.samples is not None else {})}
        ensemble = run(with_keys(text, keys), arguments.output / (f"{1e6 * time:.6g}us" if time else "immediate"), arguments.program,
                       ranks=arguments.ranks)
        if not np.issubdtype(ensemble.samples.get(arguments.result, np.array("")).dtype, np.number):
            raise RunError(f"no result '{arguments.result}' with numbers; `crackle stats --columns` lists all results")
        unit = ensemble.samples.attrs["units"].get(arguments.result, "")
        unit = "" if unit == "1" else unit
        if unit != measured_unit:
            raise RunError(f"--measured: '{arguments.result}' is {f'in {unit}' if unit else 'a pure number'}")
        columns.append(ensemble.samples[arguments.result].to_numpy(float))
        setting = f"release time {1e6 * time:.3g} us" if time else "immediate release"
        there = columns[-1][np.isfinite(columns[-1])]
        value = f"{there.mean():.4g} ± {there.std(ddof=1):.2g} {unit}".rstrip() if there.size > 1 else f"in {there.size} samples only"
        print(f"{setting}: {arguments.result} {value}", flush=True)
    results = np.array(columns)
    whole = np.isfinite(results).all(axis=0)
    if whole.sum() < 3:
        raise RunError(f"{whole.sum()} samples have a {arguments.result} at every release time, and three are needed")
    if not whole.all():
        print(f"left out: {(~whole).sum()} of {whole.size} samples without a {arguments.result} at some release time")
    found = release_time(times, results[1:, whole], measured, error)
    draw(arguments.output / "calibration.png", f"{arguments.result} [{unit}]" if unit else arguments.result, times, results[1:, whole],
         measured, error, found)
    shown = [f"{1e6 * time:.3g} us" if np.isfinite(time) else beyond for time, beyond in
             zip(found, ("", f"below {1e6 * times[0]:.3g} us", f"above {1e6 * times[-1]:.3g} us"))]
    if not shown[0]:
        print(f"no release time between {1e6 * times[0]:.3g} and {1e6 * times[-1]:.3g} us gives {f'{measured:.4g} {unit}'.rstrip()}; "
              f"immediate release gives {results[0, whole].mean():.4g}; try other --times, or see whether load and toughness are the experiment's")
    else:
        print(f'release_time = "{shown[0]}"  # 95 % interval {shown[1]} to {shown[2]}, on the spacing of this input')
    print(arguments.output / "calibration.png")
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(prog="calibrate-release", description="Computes an input with several values of [fracture] release_time and says "
                                     "with which of them a result, the crack's largest speed unless another is named, is as measured. The input "
                                     "should be the experiment's: its body, load, toughness. Finished runs are kept.")
    parser.add_argument("input", type=Path, metavar="INPUT.toml")
    parser.add_argument("--measured", type=quantity, required=True, help="the measured mean, with its unit: '450 m/s'")
    parser.add_argument("--error", type=quantity, required=True, help="its standard error, such as '20 m/s'")
    parser.add_argument("--result", default="crack_speed_max", help="a result of `crackle stats --columns` (%(default)s)")
    parser.add_argument("--times", type=seconds, nargs="+", default=[5e-8, 1e-7, 2e-7, 4e-7, 8e-7], metavar="TIME",
                        help="release times to compute (0.05, 0.1, 0.2, 0.4 and 0.8 us)")
    parser.add_argument("--samples", type=int, help="for each release time (the input's number)")
    parser.add_argument("--ranks", type=int, default=1, help="of mpirun: a master and workers (1: without mpirun)")
    return command(parser, "calibrate-release", calibrate)


if __name__ == "__main__":
    sys.exit(main())
