"""One blind trial: an experiment, what is hidden in it, how strong, where it shows, and its files."""
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the same sums on every machine, and no threads that wait on each other

import json  # noqa: E402

import numpy as np  # noqa: E402

import effects  # noqa: E402
from case_file import write_case  # noqa: E402
from experiments import KINDS  # noqa: E402
from noise import Noise  # noqa: E402
from recording_file import write_recording  # noqa: E402

LEAST = 3.4  # norm of the whitened, projected signal that a one-parameter test at 1 % sees with 80 % power
SETS = {"development": 20260100, "final": 73919000}  # seeds of trial 0; trial i has seed + i
CATEGORIES = {"none": 0.22, "parameters": 0.12, "effect": 0.34, "instrument": 0.11, "two": 0.08, "outside": 0.13}
KIND_SHARE = {"flight": 0.22, "bounce": 0.2, "impact_times": 0.1, "contact": 0.22, "oblique": 0.1, "roll": 0.11, "spin": 0.05}

# Where each effect can be seen; each name of a category is equally likely.
BODY, HIT = ["flight", "bounce", "impact_times"], ["bounce", "impact_times", "contact"]
WHERE = {
    "effect": {"air_drag": [*BODY, "roll"], "viscous_drag": [*BODY, "roll"], "buoyancy": BODY, "added_mass": ["flight"], "magnus": ["flight"],
               "rolling_resistance": ["roll"], "torsional_friction": ["spin"], "sliding_friction": ["roll", "oblique"], "tangential_compliance": ["oblique"],
               "velocity_dependent_restitution": [*HIT, "oblique"], "plastic_contact": HIT, "nonlinear_stiffness": ["contact"], "adhesion": HIT,
               "liquid_bridge": HIT, "lubrication": ["bounce", "impact_times"], "wave_loss": HIT, "powder_layer": ["contact"]},
    "instrument": {"sensor_gain": ["flight", "bounce", "contact", "roll", "oblique"], "sensor_offset": ["bounce", "contact", "oblique"],
                   "sensor_lag": ["contact"], "clock_shift": ["bounce", "contact"], "saturation": ["bounce", "contact", "flight", "spin"]},
    "outside": {"thrust_dying_out": BODY, "periodic_force": BODY, "drag_crisis": ["flight"], "force_in_band_of_height": ["flight"], "drag_v5": ["flight"],
                "side_gust": ["flight"], "spring_to_a_line": ["flight"], "magnet_below": BODY[1:], "restitution_resonance": [*BODY[1:], "oblique"],
                "force_bump_at_overlap": ["contact"], "friction_in_guide": ["contact"], "stiffness_drift_over_runs": ["contact"], "ringing": ["contact"],
                "friction_falls_with_speed": ["roll", "oblique"], "rough_patch": ["roll"], "uneven_table": ["roll"], "force_dying_out": ["roll"],
                "viscous_torque": ["spin"], "quadratic_torque": ["spin"]},
}


class Redraw(Exception):
    pass


class Frame:
    """The measuring geometry of an experiment: whitening, and the projection that free parameters and initial states leave."""

    def __init__(self, e, noise):
        self.e, self.noise = e, noise
        variants, self.columns = [{}], []
        for key, name, bounds in e.free:
            v = e.base.get(name, 0.0)
            step = 1e-3 * max(abs(v), 1e-3)
            self.columns.append((key, step))
            variants.append({"params": {name: v + step}})
        steps = {"clock": 1e-4}
        for comp in e.init:
            step = steps.get(comp) or 0.2 * e.sd.get(comp, {True: 2e-3, False: 2e-2}[comp in "xyz"])
            if comp == "wy" or comp == "wz":
                step = 0.2 * e.sd[comp]
            self.columns.append((comp, step))
            variants.append({"init": {comp: step}})
        sims = e.simulate(variants)
        self.base = e.plain = sims[0]
        self.slopes = [[either_side(s[c], e.times[r]) if noise.jitter else np.zeros(s.shape[1]) for c in range(len(e.channels))]
                       for r, s in enumerate(self.base)]
        self.offsets = np.cumsum([0] + [s.size for s in self.base])
        self.labels = [(name, r) for name, step in self.columns for r in (range(e.n) if name in e.init else [None])]
        design = self.sensitivities(sims)
        self.design = np.array(design).T if design else None
        self.basis = self.orthonormal(design)
        self.initial = self.orthonormal(design[len(e.free):])
        self.free_columns = design[:len(e.free)]

    @staticmethod
    def orthonormal(columns):
        columns = [c / np.linalg.norm(c) for c in columns if np.linalg.norm(c) > 1e-9]
        if not columns:
            return None
        q, r = np.linalg.qr(np.array(columns).T)
        return q[:, np.abs(np.diag(r)) > 1e-7]

    def white(self, run, difference):
        return np.concatenate([self.noise.whiten(difference[c], name, self.slopes[run][c]) for c, name in enumerate(self.e.channels)])

    def response(self, sim):
        return np.concatenate([self.white(r, b - a) for r, (a, b) in enumerate(zip(self.base, sim))])

    def unfitted(self, responses):
        """What calibration leaves of each response. Restitution shifts bounces by more than the sensitivities tell: the baseline is run again
        with the values they lead to, and only the rest is taken for linear."""
        best = [self.left(r) for r in responses]
        if self.design is None or self.e.kind in ("flight", "spin"):
            return best
        size = np.maximum(np.linalg.norm(self.design, axis=0), 1e-30)
        totals, rests = [np.zeros(len(size)) for _ in responses], list(responses)
        for _ in range(10):  # the sensitivities stay those of the baseline: each turn takes off most of what is left to calibrate
            variants = []
            for total, rest in zip(totals, rests):
                if np.isfinite(rest).all():
                    total += np.linalg.lstsq(self.design / size, rest, rcond=1e-9)[0] / size
                variants.append(self.calibrated(total))
            moved = False
            for i, sim in enumerate(self.e.simulate(variants)):
                rest = responses[i] - self.response(sim)
                if np.isfinite(rest).all():
                    rests[i], left = rest, self.left(rest)
                    if np.linalg.norm(left) < 0.97 * np.linalg.norm(best[i]):
                        best[i], moved = left, True
            if not moved:
                break
        return best

    def refitted(self, sim, most=4):
        """What calibration leaves of a signal, with sensitivities taken anew where it leads (Gauss and Newton)."""
        target = self.response(sim)
        best = self.unfitted([target])[0]
        if self.design is None:
            return best
        total, size = np.zeros(self.design.shape[1]), np.maximum(np.linalg.norm(self.design, axis=0), 1e-30)
        design, rest = self.design, target
        # Bounces fall out of step: a beginning of each run first, then more.
        parts = (0.15, 0.35, 0.65, 1.0) if self.e.kind in ("bounce", "impact_times") else (1.0,)
        for share in parts:
            rows = self.early(share)
            norm = np.linalg.norm(rest[rows])
            for _ in range(most):
                if not np.isfinite(design).all():  # a ball sticks there
                    break
                step = np.linalg.lstsq((design / size)[rows], rest[rows], rcond=1e-9)[0] / size
                for part in (1.0, 0.3, 0.1):
                    trial = total + part * step
                    left = target - self.response(self.e.simulate([self.calibrated(trial)])[0])
                    if np.isfinite(left).all() and np.linalg.norm(left[rows]) < norm:
                        break
                else:
                    break
                gained = norm - np.linalg.norm(left[rows])
                total, rest, norm = trial, left, np.linalg.norm(left[rows])
                if gained < 0.02 * norm:
                    break
                design = self.design_at(total)
        if np.linalg.norm(rest) < np.linalg.norm(best):
            best = rest
        return best

    def early(self, share):
        """Which samples lie in the first part of their run."""
        keep = []
        for r in range(self.e.n):
            t = np.asarray(self.e.times[r], float)
            keep += [t <= t[0] + share * (t[-1] - t[0]) + 1e-12] * len(self.e.channels)
        return np.concatenate(keep)

    def design_at(self, shift):
        """Whitened sensitivities about calibrated values."""
        variants = [self.calibrated(shift)]
        for name, step in self.columns:
            moved = shift + np.array([step if label == name else 0.0 for label, run in self.labels])
            variants.append(self.calibrated(moved))
        return np.array(self.sensitivities(self.e.simulate(variants))).T

    def sensitivities(self, sims):
        """Whitened, one column a label: of the first signal, towards the others, which are a step of each column away."""
        design = []
        for (name, step), sim in zip(self.columns, sims[1:]):
            parts = [self.white(r, (b - a) / step) for r, (a, b) in enumerate(zip(sims[0], sim))]
            if name in self.e.init:
                for r, part in enumerate(parts):
                    column = np.zeros(self.offsets[-1])
                    column[self.offsets[r]:self.offsets[r + 1]] = part
                    design.append(column)
            else:
                design.append(np.concatenate(parts))
        return design

    def calibrated(self, shift):
        """The variant whose free parameters and initial states are off by these."""
        params, init = {}, {c: np.zeros(self.e.n) for c in self.e.init}
        for (name, run), value in zip(self.labels, shift):
            if run is not None:
                init[name][run] = value
                continue
            number = next(n for key, n, _ in self.e.free if key == name)
            base = self.e.base.get(number, 0.0)
            least = 0.0 if number.endswith("friction") or number == "drag_coefficient" else 0.2 * base
            params[number] = min(max(base + value, least), 1.0 if number == "restitution" else np.inf)
        return {"params": params, "init": init}

    def left(self, response, basis="all"):
        q = self.basis if basis == "all" else self.initial
        return response if q is None else response - q @ (q.T @ response)


def variant_of(chosen):
    params = {}
    for effect, s in chosen:
        params.update(effect.values(s))
    return {"params": params}


def seen(frame, effect, strengths):
    """What effects of these strengths leave after calibration; None where a ball sticks."""
    sims = frame.e.simulate([variant_of([(effect, s)]) for s in strengths], hooks=effect.hooks)
    responses = [frame.response(x) for x in sims]
    good = [i for i, r in enumerate(responses) if np.isfinite(r).all()]
    left = frame.unfitted([responses[i] for i in good]) if good else []
    out = [None] * len(responses)
    for i, r in zip(good, left):
        out[i] = r
    return out


def strength_for(frame, effect, wanted):
    """Strength whose projected signal has the norm `wanted` (or the most that bounds allow), that norm and the signal."""
    grid = np.geomspace(min(0.01 * effect.start, 1e-3 * effect.cap), effect.cap, 9)
    sizes = [(s, np.linalg.norm(r)) for s, r in zip(grid, seen(frame, effect, grid)) if r is not None]
    sizes = [(s, size) for s, size in sizes if size > 1e-9]
    if not sizes:
        raise Redraw
    s, size = sizes[0]
    if size >= wanted:
        s = s * wanted / size
    else:
        for (a, low), (b, high) in zip(sizes, sizes[1:]):
            s = b
            if high >= wanted:
                s = a * (b / a) ** (np.log(wanted / low) / np.log(high / low))
                break
    r = seen(frame, effect, [float(s)])[0]
    if r is None:
        raise Redraw
    return float(s), np.linalg.norm(r), r


def location(frame, signal):
    """Channel and shortest interval of t that carry 90 % of the projected signal, over all runs and for each; by energy."""
    e = frame.e
    energy = [[None] * len(e.channels) for _ in range(e.n)]
    for r in range(e.n):
        part = signal[frame.offsets[r]:frame.offsets[r + 1]].reshape(len(e.channels), -1) ** 2
        for c in range(len(e.channels)):
            energy[r][c] = part[c]
    total = sum(x.sum() for row in energy for x in row) or 1.0
    by_channel = {name: float(sum(energy[r][c].sum() for r in range(e.n)) / total) for c, name in enumerate(e.channels)}
    c = int(np.argmax(list(by_channel.values())))
    times = np.concatenate([np.asarray(e.times[r], float) for r in range(e.n)])
    weight = np.concatenate([energy[r][c] for r in range(e.n)])
    shares = [float(sum(x.sum() for x in energy[r]) / total) for r in range(e.n)]
    strongest = int(np.argmax(shares))
    whole = shortest(times, weight, 0.9)
    return {"channel": e.channels[c], "variable": "impact" if e.kind == "impact_times" else "t", "unit": "1" if e.kind == "impact_times" else "s",
            "from": whole[0], "to": whole[1], "share": 0.9, "half": shortest(times, weight, 0.5), "share_by_channel": by_channel, "share_by_run": shares,
            "strongest_run": str(strongest + 1),
            "by_run": [shortest(np.asarray(e.times[r], float), energy[r][c], 0.9) for r in range(e.n)],
            "span": [float(times.min()), float(times.max())]}


def shortest(t, weight, share):
    order = np.argsort(t, kind="stable")
    t, w = t[order], np.concatenate([[0], np.cumsum(weight[order])])
    if w[-1] <= 0:
        return [float(t[0]), float(t[-1])]
    w = w / w[-1]
    last = np.minimum(np.searchsorted(w, w[:-1] + share - 1e-12), len(t))
    good = w[last] - w[:-1] >= share - 1e-9
    widths = np.where(good, t[np.minimum(last, len(t)) - 1] - t, np.inf)
    i = int(np.argmin(widths))
    return [float(t[i]), float(t[last[i] - 1])]


def catalogue(e):
    """Every effect of the catalogue that may act in this experiment."""
    if e.kind in ("roll", "spin"):
        physical = effects.on_plane(e)
    elif e.kind == "oblique":
        physical = effects.at_oblique_impact(e)
    elif e.kind == "contact":
        physical = effects.of_contacts(e)
    else:
        physical = effects.of_bodies(e) + (effects.of_contacts(e) if e.kind != "flight" else [])
    if e.kind in ("bounce", "impact_times"):  # there it is another restitution, no more
        physical = [x for x in physical if x.name != "powder_layer"]
    if "drag_coefficient" in e.base:
        physical = [x for x in physical if x.name != "air_drag"]
    instrument = effects.of_instrument(e) if e.kind != "impact_times" else []
    return physical, instrument


def fresh(rng, kind):
    e = KINDS[kind](rng)
    noise = Noise(rng, e.sd)
    noise.jitter = getattr(e, "jitter", 0.0)
    if kind == "impact_times":
        noise.correlation, noise.kind = 0.0, noise.kind if noise.kind != "correlated" else "white"
    return e, noise, Frame(e, noise)


def shift_free(e, rng, size=0.04):
    """What the case says of its free parameters is a little off; the truth is kept."""
    e.case_values = {}
    for key, name, bounds in e.free:
        true = e.base[name] if name in e.base else 0.0
        guess = true * (1 + size * rng.standard_normal())
        if name == "restitution":
            guess = min(guess, 0.99)
        e.case_values[key] = float(f"{guess:.4g}")


def draw(rng, category, kind, target=None):
    """Experiment with its hidden truth; raises Redraw where that effect cannot be seen in it."""
    e, noise, frame = fresh(rng, kind)
    physical, instrument = catalogue(e)
    chosen, hooks, ratios, leftover = [], None, [], None
    e.case_values = {}
    if category == "none":
        pass
    elif category == "parameters":
        if not e.free:
            raise Redraw
        i = int(rng.integers(len(e.free)))
        key, name, bounds = e.free[i]
        size = np.linalg.norm(frame.left(frame.free_columns[i], "initial"))
        ratio = float(np.exp(rng.uniform(np.log(1.5), np.log(15))))
        true = float(e.base[name])
        off = float(np.clip(ratio * LEAST / max(size, 1e-12), 0.001 * true, 0.3 * true)) * (1 if e.coin else -1)
        if name == "restitution":
            off = -abs(off) if true + abs(off) > 0.97 else off
        e.case_values[key] = float(f"{true + off:.5g}")
        ratios = [abs(off) * size / LEAST]
    else:
        pool = {"effect": physical, "instrument": instrument, "two": physical + instrument, "outside": effects.outside(e)}[category]
        if len(pool) < (2 if category == "two" else 1):
            raise Redraw
        low, high = {"two": (2, 10), "outside": (1, 10)}.get(category, (0.5, 10))
        wanted = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        names = rng.permutation(sorted({x.name for x in pool}))
        if target:
            names = [x for x in names if x == target]
        count = 2 if category == "two" else 1
        signals = []
        for name in names:
            same = [x for x in pool if x.name == name]
            effect = same[int(rng.integers(len(same)))]
            w = wanted if not chosen else float(np.exp(rng.uniform(np.log(2), np.log(10))))
            try:
                s, size, r = strength_for(frame, effect, w * LEAST)
            except Redraw:
                continue
            if not 0.45 * LEAST * (1 if category in ("effect", "instrument") else 2) < size < 13 * LEAST:
                continue
            if chosen and abs(r @ signals[0]) > 0.9 * np.linalg.norm(r) * np.linalg.norm(signals[0]):
                continue
            chosen.append((effect, s))
            ratios.append(float(size / LEAST))
            signals.append(r)
            if len(chosen) == count:
                break
        if len(chosen) < count:
            raise Redraw
        if category != "two":
            hooks = chosen[0][0].hooks
        if rng.random() < 0.6:
            shift_free(e, rng)
    sim = e.simulate([variant_of(chosen)], hooks=hooks)[0]
    if not all(np.isfinite(x).all() for x in sim):
        raise Redraw
    signal = frame.refitted(sim) if chosen else frame.unfitted([frame.response(sim)])[0]
    if len(chosen) == 1:
        ratios = [float(np.linalg.norm(signal) / LEAST)]
    likes, best = {}, 0.0
    if chosen:
        others = [x for x in physical + instrument if all(x.name != c.name for c, s in chosen)]
        sims = e.simulate([variant_of([(x, x.start)]) for x in others]) if others else []
        for effect, other in zip(others, sims):
            r = frame.left(frame.response(other))
            size = np.linalg.norm(r)
            if np.isfinite(size) and size > 0.02 * LEAST:
                c = float(abs(r @ signal) / size / max(np.linalg.norm(signal), 1e-30))
                likes[effect.name] = max(likes.get(effect.name, 0.0), c)
        if category == "outside":
            best = max(likes.values(), default=0.0)
            leftover = float(ratios[0] * np.sqrt(max(0.0, 1 - best**2)))
            if leftover < 0.5:
                raise Redraw
    return e, noise, frame, chosen, ratios, sim, signal, likes, leftover


def build(seed):
    """All of the trial with this seed: the same seed gives the same numbers."""
    rng = np.random.default_rng(seed)
    category = str(rng.choice(list(CATEGORIES), p=list(CATEGORIES.values())))
    target = str(rng.choice(list(WHERE[category]))) if category in WHERE else None
    for attempt in range(400):
        kind = str(rng.choice(WHERE[category][target]) if target else rng.choice(list(KIND_SHARE), p=list(KIND_SHARE.values())))
        try:
            e, noise, frame, chosen, ratios, sim, signal, likes, leftover = draw(rng, category, kind, target)
            break
        except Redraw:
            continue
    else:
        raise RuntimeError(f"seed {seed}: nothing drawn")
    shown = jittered(rng, e, noise, chosen, None if category == "two" or not chosen else chosen[0][0].hooks) if noise.jitter else sim
    values = [np.array([noise.spoil(rng, s[c], channel) for c, channel in enumerate(e.channels)]) for s in shown]
    held = np.zeros(e.n, int)
    if e.held_out_given:
        held[rng.permutation(e.n)[:max(1, e.n // 4)]] = 1
    return rng, category, e, noise, frame, chosen, ratios, sim, signal, likes, leftover, values, held


def make(seed, folder, name):
    """Writes case.toml, recordings.csv and truth.json of the trial with this seed."""
    rng, category, e, noise, frame, chosen, ratios, sim, signal, likes, leftover, values, held = build(seed)
    names = [x.name for x, s in chosen]
    expected = {"none": "nothing_missing", "parameters": "parameters_only", "outside": "unexplained"}.get(category, "omitted_physics")
    with_sd = bool(rng.random() < 0.5)
    folder.mkdir(parents=True, exist_ok=True)
    write_case(e, folder / "case.toml", name, rng)
    write_recording(e, values, noise, held if e.held_out_given else None, with_sd, folder / "recordings.csv")
    truth = {
        "trial": name, "seed": int(seed), "kind": e.kind, "law": str(e.law), "category": category, "verdict": expected,
        "effects": names if category != "outside" else [], "outside_catalogue": category == "outside",
        "outside_form": {"name": names[0], "law": chosen[0][0].note} if category == "outside" else None,
        "parameters": {k: v for x, s in chosen for k, v in x.keys(s).items()},
        "main_keys": [next(iter(x.keys(s))) for x, s in chosen],
        "strength_ratio": ratios, "leftover_ratio": leftover, "least_detectable_norm": LEAST,
        "signal_norm": float(np.linalg.norm(signal)), "look_alikes": {k: round(v, 4) for k, v in sorted(likes.items(), key=lambda x: -x[1]) if v > 0.8},
        "free": {key: float(young(e, key, e.base.get(name, 0.0))) for key, name, _ in e.free},
        "case_values": {k: float(young(e, k, v)) for k, v in e.case_values.items()},
        "where": location(frame, signal) if chosen else None, "noise": noise.describe(), "sd_given": with_sd, "held_out_given": e.held_out_given,
        "runs": e.n, "samples": int(sum(s.size for s in sim)),
    }
    (folder / "truth.json").write_text(json.dumps(truth, indent=1, default=plain) + "\n")
    return truth


def plain(x):
    return x.item() if hasattr(x, "item") else x.tolist() if hasattr(x, "tolist") else str(x)


def young(e, key, value):
    """A case's Young's modulus from the effective one (the plate is rigid)."""
    return value * (1 - e.poisson**2) if key == "material.ball.young" else value


def jittered(rng, e, noise, chosen, hooks):
    """What shows at instants that are off by the clock's jitter, while the recording tells the nominal ones."""
    nominal = e.times
    e.times = [np.clip(t + noise.jitter * rng.standard_normal(len(t)), t[0], t[-1]) for t in nominal]
    shown = e.simulate([variant_of(chosen)], hooks=hooks)[0]
    e.times = nominal
    return shown


def either_side(signal, times):
    """Root mean square of the slopes before and after each sample: at a bounce they differ."""
    slope = np.diff(signal) / np.maximum(np.diff(times), 1e-12)
    return np.sqrt(0.5 * (np.r_[slope[:1], slope] ** 2 + np.r_[slope, slope[-1:]] ** 2))
