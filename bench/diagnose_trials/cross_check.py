#!/usr/bin/python3
"""Compares the forward models with `quern run` on random baselines: cross_check.py [--count 4] [--quern PATH] [kind …].

Told is the norm of the difference over the noise of the recording, for the first run, as it is and after what calibration takes up;
3.4 over the root of the number of runs would be a visible misfit of the two programs.
"""
import argparse
import csv
import pathlib
import re
import subprocess
import sys
import tempfile


ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cases" / "diagnose" / "generators"))
import case_file  # noqa: E402
import trial  # noqa: E402
import numpy as np  # noqa: E402
from experiments import KINDS  # noqa: E402
from noise import Noise  # noqa: E402


def table(path):
    rows = list(csv.DictReader(open(path)))
    return {k.split(" ")[0]: np.array([float(r[k]) for r in rows]) for k in rows[0]}


def compare(kind, seed, quern):
    rng = np.random.default_rng(seed)
    e = KINDS[kind](rng)
    e.case_values = {}
    noise = Noise(rng, e.sd)
    frame = trial.Frame(e, noise)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        case_file.write_case(e, folder / "case.toml", "cross_check", rng)
        text = (folder / "case.toml").read_text()
        text = text.replace("charge = false", f"charge = false\ntrack = [0]\ntrack_interval = {e.ends[0] / 2000:.6g}\n" + ("contact_history = true" if kind == "contact" else ""))
        text = re.sub(r"(?s)\[diagnose\].*", "", text)
        (folder / "case.toml").write_text(text)
        done = subprocess.run([str(quern), "run", str(folder / "case.toml"), "--out", str(folder / "out")], capture_output=True, text=True)
        if done.returncode:
            return done.stderr.strip()
        track = table(folder / "out" / "track.csv")
        t, rows = np.asarray(e.times[0]), []
        for i, c in enumerate(e.channels):
            if c == "force":
                history = table(folder / "out" / "contact_history.csv")
                rows.append(np.interp(t, history["t"], history["force"], left=0, right=0))
            elif c == "displacement":
                rows.append(np.where(t < 0, frame.base[0][i], e.radius[0] - np.interp(t, track["t"], track["z"])))
            else:
                rows.append(np.interp(t, track["t"], track[c]))
    n = frame.offsets[1]
    difference = frame.response([np.array(rows)] + list(frame.base[1:]))[:n]
    columns = [c[:n] for c in frame.free_columns] + ([] if frame.initial is None else list(frame.initial[:n].T))
    columns = [c for c in columns if np.abs(c).max() > 1e-12]
    left = difference
    if columns:
        a = np.array(columns).T
        left = difference - a @ np.linalg.lstsq(a, difference, rcond=1e-9)[0]
    return f"{e.law:14} {np.linalg.norm(difference):8.3f} {np.linalg.norm(left):8.3f}   visible from {trial.LEAST / np.sqrt(e.n):.2f}"


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("kinds", nargs="*", default=["flight", "bounce", "contact", "oblique", "roll", "spin"])
    p.add_argument("--count", type=int, default=4)
    p.add_argument("--quern", type=pathlib.Path, default=ROOT / "build" / "release" / "quern")
    a = p.parse_args()
    for kind in a.kinds:
        for seed in range(a.count):
            print(f"{kind:8} {seed:3} {compare(kind, seed, a.quern)}", flush=True)


if __name__ == "__main__":
    main()
