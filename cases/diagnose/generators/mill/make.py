#!/usr/bin/python3
"""Recordings of the mill of cases/diagnose/mill_300 by LIGGGHTS: make.py [--out DIR] [NAME …]; every one without a name.

Each is a CSV of six speeds; finished speeds are kept in DIR/runs and not computed again.
"""
import argparse
import functools
import json
import pathlib
import subprocess

import numpy as np

import charge_angles
import contact
import geometry

HERE = pathlib.Path(__file__).resolve().parent
SPEEDS = [44, 51, 58, 65, 72, 79]  # rpm; the critical speed is 87.44 rpm
STEP, EVERY, SETTLE, BLOCKS = 6e-5, 160, 2.0, 10
YOUNG = 2e7 / (2 * (1 - 0.3**2))      # E* [Pa]
SHEAR = 2e7 / (4 * 1.3 * (2 - 0.3))   # G* [Pa]
MASS = geometry.DENSITY * np.pi / 6 * geometry.BALL**3

HERTZ = "hertz tangential history"
RECORDINGS = {  # name: what is hidden, seed of the first packing, time of the means [s]
    "a1": ("nothing", 1, 8), "a2": ("nothing", 2, 5), "b1": ("rolling", 3, 5), "b2": ("rolling", 4, 5), "c1": ("cohesion", 5, 5), "d1": ("damping", 6, 5),
    "e1": ("bearing", 7, 5)}
BEARING = 0.17  # N m, at any speed: of the drive, no part of the simulation


def pairs(name, value, kind="peratomtypepair 2"):
    return "fix %s all property/global %s %s" % (name, name, kind) + 4 * (" %.10g" % value) + "\n"


@functools.lru_cache
def physics(hidden):
    """Models and the lines of their properties."""
    restitution = pairs("coefficientRestitution", contact.liggghts_restitution(0.6))
    if hidden in ("nothing", "bearing"):
        return HERTZ, restitution
    if hidden == "rolling":
        return HERTZ + " rolling_friction epsd2", restitution + pairs("coefficientRollingFriction", 0.1)
    if hidden == "cohesion":
        return HERTZ + " cohesion sjkr", restitution + pairs("cohesionEnergyDensity", 4e4)
    # Dashpots that grow with √δ: restitution 0.3 of two balls that meet at 0.5 m/s, more below, less above.
    gamma = contact.root_damping(0.3, 0.5, YOUNG, geometry.BALL / 4, MASS / 2)
    return HERTZ.replace("hertz", "hertz/stiffness"), (pairs("kn", 4 / 3 * YOUNG) + pairs("kt", 8 * SHEAR) + pairs("gamman", gamma)
                                                       + pairs("gammat", gamma * np.sqrt(4 * SHEAR / YOUNG)))


def frames(path):
    with open(path) as file:
        while file.readline():
            for _ in range(2):
                file.readline()
            count = int(file.readline())
            for _ in range(5):
                file.readline()
            text = "".join(file.readline() for _ in range(count))
            yield np.fromstring(text, sep=" ").reshape(count, -1)


def reading(folder, rpm):
    """Power, shoulder and toe with the standard deviations of their means."""
    torque = np.loadtxt(folder / "torque.txt")[:, 1]
    power = torque * rpm * np.pi / 30
    layer_from = geometry.RADIUS - geometry.BAR_HEIGHT - geometry.BALL
    profiles = np.array([charge_angles.layer(f[:, 1], f[:, 2], f[:, 3], f[:, 4], f[:, 5], MASS, layer_from, geometry.BALL / 2)
                         for f in frames(folder / "places.txt")])
    parts = [part.mean() for part in np.array_split(power, BLOCKS)]
    sums = np.array([part.sum(0) for part in np.array_split(profiles, BLOCKS)])
    toe, shoulder = charge_angles.ends(sums.sum(0))
    # Jackknife: the angles are no means of angles.
    without = np.array([charge_angles.ends(sums.sum(0) - s) for s in sums])
    spread = np.sqrt((BLOCKS - 1) / BLOCKS * np.sum((without - without.mean(0)) ** 2, axis=0))
    return [power.mean(), np.std(parts, ddof=1) / np.sqrt(BLOCKS), shoulder, spread[1], toe, spread[0]]


def simulate(folder, hidden, seed, steady, rpm):
    if (folder / "reading.json").exists():
        return json.loads((folder / "reading.json").read_text())
    folder.mkdir(parents=True, exist_ok=True)
    geometry.write_stl(folder / "bars.stl", geometry.bars())
    geometry.write_stl(folder / "ends.stl", geometry.ends())
    geometry.write_start(folder / "start.data", 100 * seed + rpm)
    model, properties = physics(hidden)
    (folder / "properties.liggghts").write_text(properties)
    numbers = {"omega": rpm * np.pi / 30, "settle": round(SETTLE / STEP), "steps": round(steady / STEP), "every": EVERY, "samples": EVERY // 10, "model": model}
    command = ["liggghts", "-in", str(HERE / "in.mill")]
    for name, value in numbers.items():
        command += ["-var", name, *(["%.12g" % value] if name != "model" else [value])]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    values = reading(folder, rpm)
    (folder / "places.txt").unlink()
    (folder / "reading.json").write_text(json.dumps(values))
    return values


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/mill_recordings"))
    parser.add_argument("names", nargs="*", help="of " + ", ".join(RECORDINGS))
    options = parser.parse_args()
    for name in options.names or RECORDINGS:
        hidden, seed, steady = RECORDINGS[name]
        rows = []
        for rpm in SPEEDS:
            rows.append([rpm, *simulate(options.out / "runs" / name / str(rpm), hidden, seed, steady, rpm)])
            if hidden == "bearing":
                rows[-1][1] += BEARING * rpm * np.pi / 30
            print(name, " ".join("%.4g" % x for x in rows[-1]), flush=True)
        lines = ["# A tumbling mill of 250 mm x 64 mm with 300 steel balls of 16 mm and eight bars, at six speeds: simulated with LIGGGHTS 3.8.0.",
                 "# Means over %g s after %g s; standard deviations of those means from %d blocks. Angles as in docs/angles.md." % (steady, SETTLE, BLOCKS),
                 "speed [rpm],power [W],power_sd [W],shoulder [deg],shoulder_sd [deg],toe [deg],toe_sd [deg]"]
        lines += ["%g,%.4f,%.4f,%.2f,%.2f,%.2f,%.2f" % tuple(row) for row in rows]
        (options.out / (name + ".csv")).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
