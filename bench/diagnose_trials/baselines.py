#!/usr/bin/python3
"""Three baselines on the trials of a set: baselines.py DIR. They write DIR/<trial>/<baseline>/diagnosis.json for score.py --results <baseline>.

calibration   fits what the case says is free and stops; "parameters_only" where a parameter moved by more than 2.6 of its standard errors
sparse        derivatives of the recording by local parabolas, the residual force regressed onto a library of terms by sequential thresholding
training_fit  every effect of the catalogue nested in turn (linear in its strength), the best fit to all the data is named where it gains more
              than chi-square 6.63: the plain F-test, once, as if one effect had been tried and the noise were white
All three get the true standard deviation of the noise and the generators' own forward model: more than a user has.
"""
import argparse
import json
import pathlib
import sys


HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "cases" / "diagnose" / "generators"))
import trial  # noqa: E402
import numpy as np  # noqa: E402


def fit(columns, residual):
    """Least squares: residual left, coefficients, their standard errors."""
    if not columns:
        return residual, np.zeros(0), np.zeros(0)
    a = np.array(columns).T
    scale = np.maximum(np.linalg.norm(a, axis=0), 1e-300)
    x, _, rank, _ = np.linalg.lstsq(a / scale, residual, rcond=1e-9)
    error = np.sqrt(np.abs(np.diag(np.linalg.pinv((a / scale).T @ (a / scale)))))
    return residual - a / scale @ x, x / scale, error / scale


def naive(frame):
    """The same geometry with white noise: what a user without a noise model has."""
    frame.noise.correlation, frame.noise.jitter = 0.0, 0.0
    return frame


def rows_of(frame, held, which):
    """Mask of the whitened samples of the runs that are (not) held out."""
    mask = np.zeros(frame.offsets[-1], bool)
    for r in range(frame.e.n):
        if bool(held[r]) == which:
            mask[frame.offsets[r]:frame.offsets[r + 1]] = True
    return mask


def rms(x):
    return float(np.sqrt(np.mean(x**2))) if len(x) else None


def design_of(frame, e):
    """Free parameters and initial states as columns."""
    variants = [{}] + [{"params": {n: e.base.get(n, 0.0) + 1e-3 * max(abs(e.base.get(n, 0.0)), 1e-3)}} for _, n, _ in e.free]
    sims = e.simulate(variants)
    free = [frame.response(s) / (1e-3 * max(abs(e.base.get(n, 0.0)), 1e-3)) for (_, n, _), s in zip(e.free, sims[1:])]
    start = []
    for comp in e.init:
        h = 1e-4 if comp == "clock" else 0.2 * e.sd.get(comp, 2e-3 if comp in "xyz" else 2e-2)
        sim = e.simulate([{"init": {comp: h}}])[0]
        for r in range(e.n):
            column = np.zeros(frame.offsets[-1])
            column[frame.offsets[r]:frame.offsets[r + 1]] = frame.white(r, (sim[r] - frame.base[r]) / h)
            start.append(column)
    return free, start


def without_wild(rows):
    """Single points further than six standard deviations from the median of their neighbours are put onto it."""
    out = np.array(rows)
    for row in out:
        if len(row) >= 7:
            near = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(row, 3, mode="edge"), 7), axis=1)
            wild = np.abs(row - near) > 6
            row[wild] = near[wild]
    return out


def diagnose(verdict, effects, before, after, parameters=None, where=None, confidence=0.95):
    return {"verdict": verdict, "effect": effects[0] if len(effects) == 1 else None, "effects": effects, "indistinguishable": [], "confidence": confidence,
            "where": where, "parameters": parameters or {}, "fit": {"held_out": {"before": before, "after": after}, "noise_floor": 1.0}}


def one(seed):
    rng, category, e, noise, frame, chosen, ratios, sim, signal, likes, leftover, values, held = trial.build(seed)
    if not held.any():
        held[3::4] = 1
    frame = naive(frame)
    free, start = design_of(frame, e)
    guess = np.array([e.case_values.get(key, e.base.get(n, 0.0)) - e.base.get(n, 0.0) for key, n, _ in e.free])
    data = np.concatenate([without_wild(frame.white(r, np.array(values[r]) - frame.base[r]).reshape(len(e.channels), -1)).ravel() for r in range(e.n)])
    fits, sealed = rows_of(frame, held, False), rows_of(frame, held, True)

    def solve(extra):
        """Fit on the open runs; on the sealed ones only their own initial states are fitted."""
        shared = free + extra
        left, x, error = fit([c[fits] for c in shared + start], data[fits])
        rest = data[sealed] - sum((c[sealed] * v for c, v in zip(shared, x)), np.zeros(sealed.sum()))
        rest, _, _ = fit([c[sealed] for c in start if np.abs(c[sealed]).any()], rest)
        return left, x, error, rms(rest)
    left, x, error, before = solve([])
    # A parameter that a case has right is not moved by calibration.
    moved = [abs(v - g) > 2.6 * s for v, g, s in zip(x, guess, error)][:len(free)]
    out = {"calibration": diagnose("parameters_only" if any(moved) else "nothing_missing", [], before, before)}

    physical, instrument = trial.catalogue(e)
    pool = physical + instrument
    best, at = None, [f.start for f in pool]
    for last in (False, True):  # the response at the first strength, then at the one that it leads to
        for i, (effect, sim) in enumerate(zip(pool, e.simulate([trial.variant_of([(f, s)]) for f, s in zip(pool, at)]) if pool else [])):
            r = frame.response(sim) / at[i]
            if not np.isfinite(r).all() or np.linalg.norm(r) == 0:
                continue
            tried, x, error, after = solve([r])
            gain, strength = float(left @ left - tried @ tried), x[len(free)]
            if last and strength > 0 and (best is None or gain > best[0]):
                best = (gain, effect, strength, error[len(free)], after)
            at[i] = float(np.clip(strength, 0.02 * effect.start, effect.cap))
    if best and best[0] > 6.63:
        gain, effect, s, err, after = best
        key = next(iter(effect.keys(s)))
        low, high = (effect.keys(max(s - 1.96 * err, 1e-12))[key], effect.keys(s + 1.96 * err)[key])
        out["training_fit"] = diagnose("omitted_physics", [effect.name], before, after,
                                       {key: {"value": effect.keys(s)[key], "ci95": sorted([float(low), float(high)])}})
    else:
        out["training_fit"] = out["calibration"]
    out["sparse"] = sparse(e, values, before) or out["calibration"]
    return out


# --- sparse regression ------------------------------------------------------------------------------------------------------
def derivatives(t, y, half=4):
    """Value and two derivatives by local parabolas."""
    out = np.full((3, len(t)), np.nan)
    for i in range(half, len(t) - half):
        k = slice(i - half, i + half + 1)
        p = np.polyfit(t[k] - t[i], y[k], 2)
        out[:, i] = p[2], p[1], 2 * p[0]
    return out


LIBRARY = {  # term: the effect that it stands for
    "flight": {"1": "buoyancy", "v": "viscous_drag", "|v|v": "air_drag", "z": "sensor_gain", "t": "unexplained", "v^3": "unexplained"},
    "roll": {"1": "rolling_resistance", "v": "viscous_drag", "|v|v": "air_drag", "x": "unexplained", "v^3": "unexplained"},
    "spin": {"1": "torsional_friction", "v": "unexplained", "|v|v": "unexplained"},
    "contact": {"1": "sensor_offset", "d": "sensor_gain", "d^2": "nonlinear_stiffness", "d v": "velocity_dependent_restitution", "v": "unexplained"},
}


def sparse(e, values, before):
    kind = "flight" if e.kind == "bounce" else e.kind
    if kind not in LIBRARY:
        return None
    target, terms = [], {k: [] for k in LIBRARY[kind]}
    for r in range(e.n):
        t = np.asarray(e.times[r], float)
        if kind == "contact":
            if e.channels[0] != "force":
                return None
            inside = (t > 0) & (t < 0.9 * e.contact_time)
            f, d = np.array(values[r][0]), np.array(e.plain[r][-1] if len(e.channels) > 1 else np.sin(np.pi * np.clip(t / e.contact_time, 0, 1)) * e.deepest)
            v = np.gradient(d, t)
            size = e.peak_force
            res = (f - e.plain[r][0])[inside] / size
            d, v = d[inside] / e.deepest, v[inside] / e.reference_speed
            vals = {"1": np.ones_like(d), "d": d, "d^2": d * d, "d v": d * v, "v": v}
        else:
            channel = {"flight": "z", "roll": "x", "spin": "wz"}[kind]
            if channel not in e.channels:
                return None
            x, v, a = derivatives(t, np.array(values[r][e.channels.index(channel)]))
            if kind == "spin":
                x, v, a = v, x, v
            good = np.isfinite(a)
            if e.kind == "bounce":
                good &= x > e.radius[r] + 0.15 * e.height
            expected = {"flight": -9.81, "roll": 0.0, "spin": 0.0}[kind]
            if kind == "roll":  # after the sliding has ended
                good &= t > 0.5 * e.duration
            scale = 1.0 / e.mass[r] if kind != "spin" else 1.0
            res, x, v, tt = (a - expected)[good], x[good], v[good], t[good]
            vals = {"1": np.ones_like(v), "v": v * scale, "|v|v": np.abs(v) * v * scale * e.radius[r] ** 2, "v^3": v**3 * scale, "x": x, "z": x, "t": tt}
        target.append(res)
        for k in terms:
            terms[k].append(vals[k])
    y = np.concatenate(target)
    if len(y) < 20:
        return None
    a = {k: np.concatenate(v) for k, v in terms.items()}
    active = list(a)
    while active:
        m = np.array([a[k] / max(np.sqrt(np.mean(a[k] ** 2)), 1e-12) for k in active]).T
        x, _, _, _ = np.linalg.lstsq(m, y, rcond=1e-9)
        sigma = np.std(y - m @ x) * np.sqrt(np.abs(np.diag(np.linalg.pinv(m.T @ m))))
        weak = [k for k, c, s in zip(active, x, sigma) if abs(c) < max(3 * s, 0.05 * np.abs(x).max())]
        if not weak:
            break
        active = [k for k in active if k not in weak]
    if not active:
        return None
    k = active[int(np.argmax(np.abs(x)))]
    name = LIBRARY[kind][k]
    if name == "unexplained":
        return diagnose("unexplained", [], before, before)
    return diagnose("omitted_physics", [name], before, before)


def work(folder):
    seed = json.loads((folder / "truth.json").read_text())["seed"]
    try:
        answers = one(seed)
    except Exception as problem:  # a baseline that fails has answered nothing
        return f"{folder.name}: {type(problem).__name__}: {problem}"
    for name, answer in answers.items():
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "diagnosis.json").write_text(json.dumps(answer, default=trial.plain) + "\n")
    return None


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("-j", type=int, default=2)
    a = p.parse_args()
    folders = sorted(x.parent for x in a.folder.glob("*/truth.json"))
    import multiprocessing
    with multiprocessing.Pool(a.j) as pool:
        for n, problem in enumerate(pool.imap(work, folders), 1):
            if problem:
                print(problem, flush=True)
            if n % 20 == 0:
                print(f"{n} of {len(folders)}", flush=True)


if __name__ == "__main__":
    main()
