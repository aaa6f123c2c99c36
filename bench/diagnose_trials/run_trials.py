#!/usr/bin/python3
"""Runs `quern diagnose` on every trial of a folder: run_trials.py DIR [--quern PATH] [-j 2] [--results NAME] [--limit SECONDS].

Results go into DIR/<trial>/<results>/; a trial that has them is not run again. wall.json keeps how long it took and how it ended.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def one(trial, a):
    out = trial / a.results
    if (out / "wall.json").exists() and not a.fresh:
        return None
    shutil.rmtree(out, ignore_errors=True)
    # The truth is kept out of the program's reach: it sees copies of the case and the recording alone.
    with tempfile.TemporaryDirectory() as blind:
        for name in ("case.toml", "recordings.csv"):
            shutil.copy(trial / name, blind)
        command = [str(a.quern), "diagnose", f"{blind}/case.toml", "--recording", f"{blind}/recordings.csv", "--out", f"{blind}/result", "--no-pictures",
                   "--threads", str(max(1, (os.cpu_count() or 1) // a.j))]
        if a.seed is not None:
            command += ["--seed", str(a.seed)]
        start = time.monotonic()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=a.limit)
            code, said = done.returncode, done.stderr[-2000:]
        except subprocess.TimeoutExpired:
            code, said = -1, f"stopped after {a.limit} s"
        seconds = time.monotonic() - start
        out.mkdir(parents=True)
        for name in ("diagnosis.json", "amended.toml"):
            if (pathlib.Path(blind) / "result" / name).exists():
                shutil.copy(pathlib.Path(blind) / "result" / name, out)
    (out / "wall.json").write_text(json.dumps({"seconds": round(seconds, 3), "exit": code, "said": said}) + "\n")
    return seconds, code


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--quern", type=pathlib.Path, default=ROOT / "build" / "release" / "quern")
    p.add_argument("-j", type=int, default=2)
    p.add_argument("--results", default="result")
    p.add_argument("--limit", type=float, default=120)
    p.add_argument("--seed", type=int)
    p.add_argument("--fresh", action="store_true")
    a = p.parse_args()
    trials = sorted(t.parent for t in a.folder.glob("*/truth.json"))
    failed, times = [], []
    with concurrent.futures.ThreadPoolExecutor(a.j) as pool:
        for n, (trial, done) in enumerate(zip(trials, pool.map(lambda t: one(t, a), trials)), 1):
            if done:
                times.append(done[0])
                if done[1] != 0:
                    failed.append(trial.name)
            if n % 20 == 0 or n == len(trials):
                print(f"{n} of {len(trials)}, {len(failed)} failed" + (f", {sum(times) / len(times):.1f} s each" if times else ""), flush=True)
    if failed:
        print("failed: " + " ".join(failed))


if __name__ == "__main__":
    main()
