#!/usr/bin/python3
"""Spike-in sets: measured recordings plus what a known effect would have changed, from the generators' forward model.

Each folder gets case.toml, recordings.csv and truth.json. The noise is nature's; the truth is the effect that was added.
"""
import csv
import json
import pathlib
import re
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "generators"))
from ball import Balls, X, V  # noqa: E402

LEAST = 3.4


def read(path):
    lines = [x for x in path.read_text().splitlines() if not x.startswith("#")]
    runs = {}
    for row in csv.DictReader(lines):
        runs.setdefault(row["run"], []).append(row)
    return runs


def number(rows, name):
    return np.array([float(r[name]) for r in rows])


def added(t, start, speed, mass, diameter, axes, effect):
    """Change of the path that the effect makes, from the same state at the first frame."""
    y = np.zeros((12, 1))
    for i, axis in enumerate("xyz"):
        y[i], y[3 + i] = start.get(axis, 0.0), speed.get(axis, 0.0)
    paths = []
    for extra in ({}, effect):
        balls = Balls({"mass": mass, "radius": diameter / 2, **extra}, 1, wall=False)
        paths.append(balls.run(y, t[-1] - t[0], flight_step=0.005).at(0, t - t[0])[0])
    return {axis: (paths[1] - paths[0])["xyz".index(axis)] for axis in axes}


def launch(t, values):
    """Speed at the first frame from a parabola of known g (z) or a straight line."""
    s = t - t[0]
    return np.polyfit(s, values, 1)[1], np.polyfit(s, values, 1)[0]


def seen(t, signal, residual_of):
    """Norm of the signal that a free start leaves, whitened with the run's own noise (lag 1)."""
    design = np.stack([np.ones_like(t), t - t[0]])
    q, _ = np.linalg.qr(design.T)
    r = residual_of - q @ (q.T @ residual_of)
    rho = float(np.clip(r[1:] @ r[:-1] / (r @ r), 0, 0.95))
    sd = np.sqrt((r @ r) / max(len(r) - 2, 1) * (1 - rho**2))
    white = [(c[1:] - rho * c[:-1]) / sd for c in (signal, *design)]
    q, _ = np.linalg.qr(np.array(white[1:]).T)
    left = white[0] - q @ (q.T @ white[0])
    return float(left @ left)


def write(name, case, runs, axes, effect, keys, effects, note, scale=1.0, source=""):
    folder = HERE / name
    folder.mkdir(exist_ok=True)
    lines = [f"# {source}", f"# {note}"]
    columns = ["run", "t [s]"] + [f"{a} [m]" for a in axes] + ["mass [kg]", "diameter [m]", "held_out"]
    lines.append(",".join(columns))
    power = 0.0
    for run, rows in runs.items():
        t = number(rows, "t [s]")
        values = {a: number(rows, f"{a} [m]") * scale for a in axes}
        mass, diameter, held = rows[0]["mass [kg]"], rows[0]["diameter [m]"], rows[0]["held_out"]
        start, speed, plain = {}, {}, {}
        for a in axes:
            plain[a] = values[a] + (4.905 * (t - t[0]) ** 2 if a == "z" else 0)
            start[a], speed[a] = launch(t, plain[a])
        change = {a: 0 * t for a in axes}
        if "gain" in effect:
            change = {a: values[a] * (effect["gain"] - 1) for a in axes}
        elif effect:
            change = added(t, start, speed, float(mass), float(diameter), axes, effect)
        power += sum(seen(t, change[a], plain[a]) for a in axes)
        for i in range(len(t)):
            cells = [run, f"{t[i]:.6f}"] + [f"{values[a][i] + change[a][i]:.6f}" for a in axes]
            lines.append(",".join(cells + ([mass, diameter, held] if i == 0 else ["", "", ""])))
    (folder / "recordings.csv").write_text("\n".join(lines) + "\n")
    text = re.sub(r"(?m)^name = .*", f'name = "{name}"', case, count=1)
    (folder / "case.toml").write_text(text)
    truth = {"trial": name, "kind": "flight", "category": "effect" if effects else "none", "verdict": "omitted_physics" if effects else "nothing_missing",
             "effects": effects, "outside_catalogue": False, "outside_form": None, "parameters": keys, "main_keys": list(keys)[:1],
             "strength_ratio": [round(np.sqrt(power) / LEAST, 2)] if effects else [], "leftover_ratio": None, "look_alikes": {}, "where": None,
             "runs": len(runs), "note": note}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n")
    print(f"{name}: {len(runs)} runs, strength {truth['strength_ratio']}")


def main():
    drops = read(HERE.parent / "ball_drops" / "recordings.csv")
    heavy = {r: rows for r, rows in drops.items() if r.split("/")[0] in ("bowling_ball", "baseball", "golf_ball")}
    case = (HERE.parent / "ball_drops" / "case.toml").read_text()
    source = "Spike-in, made by cases/diagnose/spike_in/make.py from cases/diagnose/ball_drops/recordings.csv (de Silva et al. 2020, MIT licence, see there)."
    write("drops_plain", case, heavy, "z", {}, {}, [], "Bowling ball, baseball and golf ball as recorded: nothing added.", source=source)
    for name, c in (("drops_drag_weak", 0.12), ("drops_drag", 0.45)):
        write(name, case, heavy, "z", {"drag_coefficient": c}, {"medium.drag_coefficient": c}, ["air_drag"],
              "Bowling ball, baseball and golf ball as recorded, plus what quadratic drag would have changed; how much: truth.json.", source=source)
    cubes = {r: rows for r, rows in read(HERE.parent / "cube_toss" / "recordings.csv").items() if r.startswith("fly/")}
    for rows in cubes.values():
        rows[0]["mass [kg]"], rows[0]["diameter [m]"] = "0.37", "0.1048"
    case = (HERE.parent / "cube_toss" / "case.toml").read_text()
    source = ("Spike-in, made by cases/diagnose/spike_in/make.py from the flights of cases/diagnose/cube_toss/recordings.csv (ContactNets, BSD-3-Clause, see there), "
              "lengths divided by 0.977.")
    write("cubes_plain", case, cubes, "xyz", {}, {}, [], "Nothing added.", scale=1 / 0.977, source=source)
    write("cubes_viscous", case, cubes, "xyz", {"viscous_drag": 0.03}, {"medium.viscous_drag": 0.03}, ["viscous_drag"],
          "Plus what a force against the velocity and in proportion to it would have changed; how much: truth.json.", scale=1 / 0.977, source=source)
    write("cubes_gain", case, cubes, "xyz", {"gain": 1.01}, {"instrument.gain": 1.01}, ["sensor_gain"], "Plus another gain of the lengths; how much: truth.json.",
          scale=1 / 0.977, source=source)


if __name__ == "__main__":
    main()
