#!/usr/bin/env python3
"""Compares `host-sim som` with MiniSom on data like that of a sonar ring.

    pip install minisom numpy
    cargo build --release
    python3 docs/minisom/compare.py target/release/host-sim

Two questions, each for several seeds and one table of samples per seed:

1. Same start, same order, same schedules: do both give the same map? Expected for every seed: within
   2 % of the quantization error and within 0.03 of the topographic error.
2. Defaults against defaults, same number of presentations: is ours at least as good in both errors, on average?

Both maps are measured with the same code, in 64-bit floats, from their code vectors. MiniSom's own
topographic error counts diagonal neighbors as neighbors (distance above 1.42); ours does not. The
table shows the 4-neighbor figure for both.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from minisom import MiniSom

SENSORS = 16
FLAGS = {"4x4": (4, 4), "chain:16": (16, 1)}


def sonar_like(seed, count):
    """Situations of a ring of 16 range sensors that looks around in rectangular rooms.

    Each sample: a room of 3 to 8 m by 3 to 8 m, a robot anywhere in it at least 0.4 m from the walls, any heading. A
    sensor hears the nearest wall within its 25 degree lobe; the range has noise of 1 % and is lost (no echo) with
    probability 2 %. 1 = obstacle at 0.25 m or nearer, 0 = nothing within 3 m, straight in between; values are rounded
    to 1/255.
    """
    rng = np.random.default_rng(seed)
    lobe = np.radians(np.linspace(-12.5, 12.5, 7))
    samples = np.empty((count, SENSORS))
    for sample in samples:
        sides = rng.uniform(3.0, 8.0, 2)
        place = rng.uniform(0.4, sides - 0.4)
        bearings = rng.uniform(0.0, 2.0 * math.pi) + 2.0 * math.pi * np.arange(SENSORS) / SENSORS
        rays = bearings[:, None] + lobe
        directions = np.stack([np.cos(rays), np.sin(rays)])
        gaps = np.where(directions > 0.0, (sides - place)[:, None, None], place[:, None, None])
        ranges = (gaps / np.maximum(np.abs(directions), 1e-9)).min(axis=0).min(axis=1)
        ranges *= rng.normal(1.0, 0.01, SENSORS)
        ranges[rng.random(SENSORS) < 0.02] = math.inf
        value = np.clip((3.0 - ranges) / (3.0 - 0.25), 0.0, 1.0)
        sample[:] = np.round(value * 255.0) / 255.0
    return samples


def errors(code, data, rows):
    """Quantization error and 4-neighbor topographic error of code vectors that stand row by row."""
    columns = len(code) // rows
    distances = np.linalg.norm(data[:, None, :] - code[None, :, :], axis=2)
    first, second = np.argsort(distances, axis=1, kind="stable")[:, :2].T
    steps = np.abs(first // columns - second // columns) + np.abs(first % columns - second % columns)
    return distances.min(axis=1).mean(), (steps != 1).mean()


def ours(command, folder, data, grid, epochs, flags):
    """Trains our map; returns its errors as measured here and checks those it printed itself."""
    table = folder / "data.csv"
    np.savetxt(table, data, delimiter=",", fmt="%.6f")
    call = [*command, "som", "--data", table, "--grid", grid, "--epochs", epochs, "--scale", "0:1"]
    call += ["--out", folder / "out", "--json", *flags]
    result = subprocess.run([str(word) for word in call], check=True, capture_output=True, text=True)
    printed = json.loads(result.stdout)
    code = np.loadtxt(folder / "out" / "code_vectors.csv", delimiter=",", ndmin=2)
    quantization, topographic = errors(code, data, rows=FLAGS[grid][1])
    assert abs(printed["quantization_error"] - quantization) < 1e-5, (printed, quantization)
    assert abs(printed["topographic_error"] - topographic) < 1e-9, (printed, topographic)
    return quantization, topographic


def minisom(grid, seed):
    """An untrained MiniSom with its defaults, its first axis along our rows."""
    columns, rows = FLAGS[grid]
    return MiniSom(rows, columns, SENSORS, sigma=1.0, learning_rate=0.5, random_seed=seed)


def weights(som):
    """Code vectors row by row."""
    return som.get_weights().reshape(-1, SENSORS)


def same_training(command, folder, data, grid, epochs, seed):
    """Same start, file order, same schedules: MiniSom's asymptotic decay ends at a third of the start."""
    som = minisom(grid, seed)
    som.random_weights_init(data)
    start = folder / "start.csv"
    np.savetxt(start, weights(som), delimiter=",", fmt="%.6f")
    som.train(data, epochs * len(data))
    flags = ["--init", start, "--order", "file", "--neighborhood", "gaussian"]
    flags += ["--rate", f"0.5:{0.5 / 3}:inverse", "--radius", f"1:{1 / 3}:inverse"]
    theirs = errors(weights(som), data, rows=FLAGS[grid][1])
    return theirs, ours(command, folder, data, grid, epochs, flags)


def defaults(command, folder, data, grid, epochs, seed):
    """Defaults against defaults with the same number of presentations; the better of MiniSom's two usual starts."""
    found = []
    for from_samples in (False, True):
        som = minisom(grid, seed)
        if from_samples:
            som.random_weights_init(data)
        som.train_random(data, epochs * len(data))
        found.append(errors(weights(som), data, rows=FLAGS[grid][1]))
    theirs = tuple(np.min(found, axis=0))
    return theirs, ours(command, folder, data, grid, epochs, ["--seed", seed])


def table(title, run, command, options):
    """Runs one comparison for all seeds and prints it."""
    print(f"\n{title}\n\n| seed | QE MiniSom | QE ours | ratio | TE MiniSom | TE ours | difference |")
    print("|---:|---:|---:|---:|---:|---:|---:|")
    rows = []
    for seed in range(options.first, options.first + options.seeds):
        data = sonar_like(seed, options.samples)
        with tempfile.TemporaryDirectory() as folder:
            theirs, own = run(command, Path(folder), data, options.grid, options.epochs, seed)
        rows.append([*theirs, *own])
        show(str(seed), rows[-1])
    show("mean", np.mean(rows, axis=0))
    return np.array(rows)


def show(name, row):
    quantization, topographic, own_quantization, own_topographic = row
    ratio, difference = own_quantization / quantization, own_topographic - topographic
    print(
        f"| {name} | {quantization:.4f} | {own_quantization:.4f} | {ratio:.4f} "
        f"| {topographic:.4f} | {own_topographic:.4f} | {difference:+.4f} |"
    )


def main():
    parser = argparse.ArgumentParser(description="Compares `host-sim som` with MiniSom.")
    parser.add_argument("program", nargs="?", help="host-sim's binary [default: through cargo]")
    parser.add_argument("--grid", default="4x4", choices=FLAGS)
    parser.add_argument("--samples", type=int, default=1000)
    parser.add_argument("--epochs", type=int, default=20)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=1, help="first seed")
    options = parser.parse_args()
    cargo = ["cargo", "run", "--quiet", "--release", "-p", "host-sim", "--"]
    command = [options.program] if options.program else cargo
    same = table("Same start, order and schedules", same_training, command, options)
    free = table("Defaults against defaults", defaults, command, options)
    ratio = np.abs(same[:, 2] / same[:, 0] - 1.0)
    difference = np.abs(same[:, 3] - same[:, 1])
    print(f"\nSame training, mean (worst seed): quantization error within {100 * ratio.mean():.2f} ({100 * ratio.max():.2f}) %,")
    print(f"topographic error within {difference.mean():.4f} ({difference.max():.4f}).")
    theirs_quantization, theirs_topographic, quantization, topographic = free.mean(axis=0)
    better = quantization <= theirs_quantization and topographic <= theirs_topographic
    both = ((free[:, 2] <= free[:, 0]) & (free[:, 3] <= free[:, 1])).sum()
    print(f"Defaults at least as good on average: {'yes' if better else 'no'}; in both errors at once: {both} of {len(free)} seeds.")
    return 0 if ratio.max() <= 0.02 and difference.max() <= 0.03 and better else 1


if __name__ == "__main__":
    sys.exit(main())
