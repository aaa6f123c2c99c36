#!/usr/bin/python3
"""Diagnoses trials with what is hidden already in the case: with_truth.py DIR [--quern PATH] [-j 2] [name …].

Nothing should then be missing; where something is, the program and the generators do not mean the same by that effect. Told are
verdict, p of the calibrated case, and by how many standard deviations each free parameter is off.
"""
import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def keys_of(truth):
    """The hidden numbers and the true free ones, by the names that a case gives them."""
    numbers = {**truth["free"], **truth["parameters"]}
    group = numbers.pop("instrument.channels", None)
    named = {}
    for key, value in numbers.items():
        if key == "instrument.shift":
            key = "instrument.clock_shift"
        elif group and key.startswith("instrument."):
            key = key.replace("instrument.", f"instrument.{group}.")
        named[key] = value
    return named


def with_keys(text, numbers):
    """A case with those keys set, each in its table."""
    lines = text.split("\n")
    for key, value in numbers.items():
        table, name = key.rsplit(".", 1)
        line = f"{name} = {json.dumps(value)}"
        heads = [i for i, one in enumerate(lines) if one.split("#")[0].strip() == f"[{table}]"]
        if not heads:
            lines += [f"[{table}]", line]
            continue
        at = heads[0] + 1
        while at < len(lines) and not lines[at].startswith("[") and lines[at].split("=")[0].strip() != name:
            at += 1
        if at < len(lines) and lines[at].split("=")[0].strip() == name:
            lines[at] = line
        else:
            lines.insert(heads[0] + 1, line)
    return "\n".join(lines)


def one(trial, quern):
    truth = json.loads((trial / "truth.json").read_text())
    if truth["outside_catalogue"]:
        return None
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder) / "case.toml"
        case.write_text(with_keys((trial / "case.toml").read_text(), keys_of(truth)))
        done = subprocess.run([str(quern), "diagnose", str(case), "--recording", str(trial / "recordings.csv"), "--out", f"{folder}/out", "--threads", "1", "--no-pictures"],
                              capture_output=True, text=True)
        head = f"{trial.name} {truth['kind']:12} {'+'.join(truth['effects']) or 'nothing':28}"
        if done.returncode:
            return f"{head} failed: {done.stderr.strip()[:200]}"
        said = json.loads((pathlib.Path(folder) / "out" / "diagnosis.json").read_text())
    off = []
    for key, told in said["parameters"].items():
        if key in truth["free"]:
            low, high = told["ci95"]
            off.append(f"{key.split('.')[-1]} {(told['value'] - truth['free'][key]) / max((high - low) / 3.92, 1e-300):+.1f}")
    return f"{head} {said['verdict']:16} p {said['adequacy']['before']:<8.3g} {', '.join(off)}"


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("names", nargs="*")
    p.add_argument("--quern", type=pathlib.Path, default=ROOT / "build" / "release" / "quern")
    p.add_argument("-j", type=int, default=2)
    a = p.parse_args()
    trials = [t.parent for t in sorted(a.folder.glob("*/truth.json")) if not a.names or t.parent.name in a.names]
    with concurrent.futures.ThreadPoolExecutor(a.j) as pool:
        for line in pool.map(lambda t: one(t, a.quern), trials):
            if line:
                print(line, flush=True)


if __name__ == "__main__":
    main()
