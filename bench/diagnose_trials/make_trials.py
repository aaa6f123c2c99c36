#!/usr/bin/python3
"""Draws blind trials: make_trials.py --set development|final [--count N] [--seed S] [--out DIR]. Same seed, same files.

Trial i of a set has the seed of the set + i (cases/diagnose/generators/trial.py); the two sets share none.
"""
import argparse
import collections
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "cases" / "diagnose" / "generators"))
import trial  # noqa: E402

COUNTS = {"development": 200, "final": 300}


def one(job):
    seed, folder, name = job
    if (folder / "truth.json").exists():
        return "kept"
    return trial.make(seed, folder, name)["category"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", choices=trial.SETS, default="development")
    parser.add_argument("--count", type=int, help="default: 200 development, 300 final")
    parser.add_argument("--seed", type=int, help="seed of trial 0; default: that of the set")
    parser.add_argument("--out", type=pathlib.Path, help="default: out/diagnose_trials/SET")
    parser.add_argument("-j", type=int, default=2)
    a = parser.parse_args()
    count = a.count or COUNTS[a.set]
    seed = trial.SETS[a.set] if a.seed is None else a.seed
    out = a.out or HERE.parents[1] / "out" / "diagnose_trials" / a.set
    jobs = [(seed + i, out / f"{i:04d}", f"trial_{i:04d}") for i in range(count)]
    tally = collections.Counter()
    if a.j > 1:
        import multiprocessing
        with multiprocessing.Pool(a.j) as pool:
            for n, category in enumerate(pool.imap(one, jobs), 1):
                tally[category] += 1
                if n % 20 == 0:
                    print(f"{n} of {count}", flush=True)
    else:
        for job in jobs:
            tally[one(job)] += 1
    print(f"{out}: " + ", ".join(f"{v} {k}" for k, v in sorted(tally.items())))


if __name__ == "__main__":
    main()
