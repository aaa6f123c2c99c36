#!/usr/bin/python3
"""Scores diagnosis.json beside truth.json: score.py DIR [--results NAME] [--out FILE.json]. Every figure with its 95 % interval.

What counts as what is written in README.md.
"""
import argparse
import collections
import json
import math
import pathlib
import random

VERDICTS = ["nothing_missing", "parameters_only", "omitted_physics", "unexplained", "insufficient_data", "failed"]
OFF = {"gain": 1.0, "unloading_ratio": 1.0, "tangential_compliance": 0.0}
CONFIDENT = 0.8
STRENGTHS = [(0, 1), (1, 2), (2, 3), (3, 5), (5, 1e9)]


def wilson(k, n):
    if n == 0:
        return {"value": None, "k": 0, "n": 0, "ci95": [None, None]}
    p, z = k / n, 1.959964
    middle, half = (p + z * z / (2 * n)) / (1 + z * z / n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return {"value": p, "k": k, "n": n, "ci95": [max(0.0, middle - half), min(1.0, middle + half)]}


def median(values, rng):
    values = [v for v in values if v is not None and math.isfinite(v)]
    if not values:
        return {"value": None, "n": 0, "ci95": [None, None]}

    def mid(v):
        v, n = sorted(v), len(v)
        return v[n // 2] if n % 2 else 0.5 * (v[n // 2 - 1] + v[n // 2])
    drawn = sorted(mid(rng.choices(values, k=len(values))) for _ in range(1000))
    return {"value": mid(values), "n": len(values), "ci95": [drawn[24], drawn[974]]}


class Answer:
    """One trial: what was hidden and what was said."""

    def __init__(self, truth, said, wall):
        self.truth, self.said, self.wall = truth, said or {}, wall
        self.verdict = self.said.get("verdict", "failed") if said else "failed"
        effects = self.said.get("effects") or ([self.said["effect"]] if self.said.get("effect") else [])
        self.effects = set(effects) if self.verdict == "omitted_physics" else set()
        self.set = self.effects | set(self.said.get("indistinguishable") or []) if self.effects else set()
        self.confidence = self.said.get("confidence")
        self.hidden = set(truth["effects"])
        self.category = truth["category"]
        self.ratio = min(truth["strength_ratio"], default=0.0)
        if self.category == "outside":
            self.ratio = truth["leftover_ratio"]

    named = property(lambda s: s.effects == s.hidden and bool(s.hidden))
    covered = property(lambda s: bool(s.hidden) and s.hidden <= s.set)
    small_set = property(lambda s: s.covered and len(s.set) <= max(2, len(s.hidden)))
    nothing = property(lambda s: s.category in ("none", "parameters"))
    false_alarm = property(lambda s: s.nothing and s.verdict in ("omitted_physics", "unexplained"))

    @property
    def wrong_name(self):
        """Some name it gives is not true, and the truth is not among the look-alikes it admits."""
        return bool(self.effects - self.hidden) and not self.covered

    @property
    def right(self):
        """Right for the reliability of the confidence: a weak effect may go unseen."""
        if self.category in ("effect", "instrument", "two"):
            if self.covered:
                return True
            return self.ratio < 1 and self.verdict in ("nothing_missing", "parameters_only", "insufficient_data")
        if self.category == "outside" and self.ratio < 1 and self.verdict in ("nothing_missing", "parameters_only", "insufficient_data"):
            return True
        if self.category == "none":
            return self.verdict in ("nothing_missing", "parameters_only")
        return self.verdict == self.truth["verdict"]

    def overlap(self):
        """Intersection over union of the intervals of t; 0 in the wrong channel; None where the answer tells none of t."""
        told, true = self.said.get("where"), self.truth["where"]
        if not told or not true or told.get("variable") != true["variable"] or told.get("from") is None or told.get("to") is None:
            return None
        if told.get("channel") != true["channel"] and not (true["variable"] == "impact"):
            return 0.0
        a, b = true["from"], true["to"]
        run = str(told.get("run") or "")
        if run.isdigit() and 1 <= int(run) <= len(true["by_run"]):
            a, b = true["by_run"][int(run) - 1]
        low, high = sorted((told["from"], told["to"]))
        joint, whole = min(b, high) - max(a, low), max(b, high) - min(a, low)
        return max(0.0, joint) / whole if whole > 0 else 0.0

    def parameter(self):
        """(relative error of the effect's size, whether its interval holds the truth); None where not comparable."""
        if not self.named or len(self.hidden) != 1:
            return None
        key = self.truth["main_keys"][0]
        short = key.split(".")[-1]
        told = self.said.get("parameters") or {}
        p = told.get(key) or told.get(short)
        if not isinstance(p, dict) or p.get("value") is None:
            return None
        true, off = self.truth["parameters"][key], OFF.get(short, 0.0)
        ci = p.get("ci95") or [None, None]
        held = None if None in ci else ci[0] <= true <= ci[1]
        return abs(p["value"] - true) / abs(true - off), held

    def removed(self):
        """Share of the excess error on sealed data that the answer removes."""
        fit = self.said.get("fit") or {}
        held = fit.get("held_out") or {}
        before, after, floor = held.get("before"), held.get("after"), fit.get("noise_floor", 1.0) or 1.0
        if before is None or after is None or before < 1.05 * floor:
            return None
        return (before - after) / (before - floor)


def read(folder, results):
    out = []
    for truth in sorted(folder.glob("*/truth.json")):
        where = truth.parent / results
        wall = json.loads((where / "wall.json").read_text()) if (where / "wall.json").exists() else None
        said = where / "diagnosis.json"
        if wall is None and not said.exists():
            continue
        try:
            answer = json.loads(said.read_text())
        except (OSError, ValueError):
            answer = None
        out.append(Answer(json.loads(truth.read_text()), answer, wall))
    return out


def score(answers):
    rng = random.Random(1)

    def share(of, among):
        chosen = [x for x in answers if among(x)]
        return wilson(sum(1 for x in chosen if of(x)), len(chosen))

    def single(x):
        return x.category in ("effect", "instrument")
    out = {"trials": len(answers)}
    confusion = collections.Counter((x.category, x.verdict) for x in answers)
    out["verdicts"] = {c: {v: confusion[c, v] for v in VERDICTS if confusion[c, v]} for c in sorted({x.category for x in answers})}
    names = collections.defaultdict(collections.Counter)
    for x in answers:
        if single(x) and x.ratio >= 1:
            names[x.truth["effects"][0]]["+".join(sorted(x.effects)) or x.verdict] += 1
        if x.category == "outside":
            names["outside: " + x.truth["outside_form"]["name"]]["+".join(sorted(x.effects)) or x.verdict] += 1
    out["confusion"] = {k: dict(v.most_common()) for k, v in sorted(names.items())}
    out["false_alarms"] = share(lambda x: x.false_alarm, lambda x: x.nothing)
    out["wrong_names"] = share(lambda x: x.wrong_name, lambda x: True)
    out["confident_wrong_names"] = share(lambda x: x.wrong_name and (x.confidence or 0) >= CONFIDENT, lambda x: True)
    for what, test in (("right_name", lambda x: x.named), ("right_set_of_two", lambda x: x.small_set), ("covered", lambda x: x.covered)):
        out[what] = {"at_least_3": share(test, lambda x: single(x) and x.ratio >= 3)}
        out[what]["at_least_3_without_look_alike"] = share(test, lambda x: single(x) and x.ratio >= 3 and max(x.truth["look_alikes"].values(), default=0) < 0.95)
        for low, high in STRENGTHS:
            out[what][f"{low} to {high:g}" if high < 1e8 else f"over {low}"] = share(test, lambda x: single(x) and low <= x.ratio < high)
        out[what]["two_at_once"] = share(test, lambda x: x.category == "two")
    out["parameters_only"] = share(lambda x: x.verdict == "parameters_only", lambda x: x.category == "parameters")
    out["unexplained_outside"] = {"all": share(lambda x: x.verdict == "unexplained", lambda x: x.category == "outside"),
                                  "at_least_3": share(lambda x: x.verdict == "unexplained", lambda x: x.category == "outside" and x.ratio >= 3)}
    seen = [x for x in answers if x.category in ("effect", "instrument", "two", "outside") and x.verdict in ("omitted_physics", "unexplained")]
    overlaps = [x.overlap() for x in seen]
    out["location_overlap"] = {**median(overlaps, rng), "not_comparable": sum(v is None for v in overlaps)}
    fits = [x.parameter() for x in answers if x.named]
    told = [f for f in fits if f]
    out["parameter_error"] = {**median([f[0] for f in told], rng), "not_comparable": len(fits) - len(told)}
    out["interval_coverage"] = wilson(sum(bool(f[1]) for f in told if f[1] is not None), sum(f[1] is not None for f in told))
    out["excess_removed"] = median([x.removed() for x in seen if x.ratio >= 1], rng)
    bins = []
    for low, high in ((0, 0.5), (0.5, 0.7), (0.7, 0.8), (0.8, 0.9), (0.9, 0.95), (0.95, 0.99), (0.99, 1.0001)):
        inside = [x for x in answers if x.confidence is not None and low <= x.confidence < high]
        if inside:
            bins.append({"from": low, "to": min(high, 1.0), "stated": sum(x.confidence for x in inside) / len(inside), "right": wilson(sum(x.right for x in inside), len(inside))})
    out["reliability"] = bins
    total = sum(b["right"]["n"] for b in bins)
    out["calibration_error"] = sum(b["right"]["n"] * abs(b["stated"] - b["right"]["value"]) for b in bins) / total if total else None
    times = [x.wall["seconds"] for x in answers if x.wall]
    out["seconds"] = {"median": median(times, rng)["value"], "largest": max(times, default=None)}
    return out


def text(v, percent=True):
    if v["value"] is None:
        return "–"
    scale, unit = (100, " %") if percent else (1, "")
    low, high = v["ci95"]
    size = f" of {v['n']}"
    return f"{v['value'] * scale:.3g}{unit} ({low * scale:.3g} … {high * scale:.3g}){size}"


def table(s):
    rows = [("false alarms (nothing hidden)", text(s["false_alarms"]), "≤ 5 %"), ("wrong names at confidence ≥ 0.8, of all trials", text(s["confident_wrong_names"]), "≤ 5 %"),
            ("wrong names, any confidence", text(s["wrong_names"]), ""), ("right name at ≥ 3 × least detectable", text(s["right_name"]["at_least_3"]), "≥ 90 %"),
            ("right set of at most two", text(s["right_set_of_two"]["at_least_3"]), "≥ 95 %"),
            ("right name at ≥ 3 ×, no look-alike in these recordings", text(s["right_name"]["at_least_3_without_look_alike"]), "")]
    for low, high in STRENGTHS:
        key = f"{low} to {high:g}" if high < 1e8 else f"over {low}"
        rows.append((f"right name, strength {key}", text(s["right_name"][key]), ""))
        rows.append((f"right set of at most two, strength {key}", text(s["right_set_of_two"][key]), ""))
    rows += [("both of two at once named", text(s["right_name"]["two_at_once"]), ""), ("parameters only: said so", text(s["parameters_only"]), ""),
             ("outside the catalogue: unexplained", text(s["unexplained_outside"]["all"]), "≥ 80 %"),
             ("outside, at ≥ 3 × beyond the nearest effect", text(s["unexplained_outside"]["at_least_3"]), ""),
             ("location: intersection over union, median", text(s["location_overlap"], False), "≥ 0.6"),
             ("parameter error, median", text(s["parameter_error"]), "≤ 10 %"), ("95 % intervals hold the truth", text(s["interval_coverage"]), "90 … 98 %"),
             ("excess error removed on sealed data, median", text(s["excess_removed"]), "≥ 80 %")]
    out = ["| figure | value (95 % interval) | wanted |", "|---|---|---|"] + [f"| {a} | {b} | {c} |" for a, b, c in rows]
    out += ["", "| hidden \\ said | " + " | ".join(VERDICTS) + " |", "|---|" + "---|" * len(VERDICTS)]
    out += [f"| {c} | " + " | ".join(str(v.get(x, 0)) for x in VERDICTS) + " |" for c, v in s["verdicts"].items()]
    out += ["", "| stated confidence | right |", "|---|---|"] + [f"| {b['stated']:.3f} | {text(b['right'])} |" for b in s["reliability"]]
    out += ["", "| hidden (at ≥ 1 ×) | said |", "|---|---|"] + [f"| {k} | " + ", ".join(f"{n} {c}" for n, c in v.items()) + " |" for k, v in s["confusion"].items()]
    return "\n".join(out)


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--results", default="result")
    p.add_argument("--out", type=pathlib.Path)
    a = p.parse_args()
    s = score(read(a.folder, a.results))
    print(table(s))
    if s["seconds"]["median"] is not None:
        print(f"\n{s['trials']} trials, median {s['seconds']['median']:.2f} s, longest {s['seconds']['largest']:.1f} s")
    (a.out or a.folder / f"score_{a.results}.json").write_text(json.dumps(s, indent=1) + "\n")


if __name__ == "__main__":
    main()
