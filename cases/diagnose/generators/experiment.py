"""What random experiments share: sizes, sampling, the instrument, and the forward model for many variants at once.

A variant is {"params": {number: value or one per run}, "init": {component: shift}}; the result is signals[variant][run][channel, sample].
"""
import numpy as np
from scipy.signal import lfilter

from ball import Balls

UNITS = {"x": "m", "y": "m", "z": "m", "vx": "m/s", "vy": "m/s", "vz": "m/s", "wx": "rad/s", "wy": "rad/s", "wz": "rad/s",
         "force": "N", "displacement": "m", "impact_time": "s"}
ROW = {"x": 0, "y": 1, "z": 2, "vx": 3, "vy": 4, "vz": 5, "wx": 6, "wy": 7, "wz": 8}
GROUPS = {"position": "xyz", "velocity": ("vx", "vy", "vz"), "spin": ("wx", "wy", "wz"), "force": ("force",), "displacement": ("displacement",)}
STIFFNESS = ("normal_stiffness", "effective_young", "effective_shear", "stiffness_coefficient")


def log_uniform(rng, low, high, n=None):
    return np.exp(rng.uniform(np.log(low), np.log(high), n))


class Experiment:
    kind = ""
    spins = schiller = knows_time = False
    fluid_density, surface_tension = 1.2, 0.0728
    contact_time = deepest = peak_force = peak_pressure = 0.0
    law, shear = "linear", "none"

    def common(self, rng, low=4, high=16):
        self.n = int(rng.integers(low, high + 1))
        self.coin = rng.random() < 0.5
        self.base, self.free, self.init, self.conditions = {}, [], [], {}
        self.initial_state = "recording"
        self.held_out_given = rng.random() < 0.5

    def sizes(self, rng, radius, density, spread=1.0):
        """Masses and radii: one ball for all runs, or several."""
        kinds = int(rng.integers(1, self.n + 1)) if rng.random() < 0.7 else 1
        r0, d0 = log_uniform(rng, *radius), log_uniform(rng, *density)
        r = np.clip(r0 * log_uniform(rng, 1 / (1 + spread), 1 + spread, kinds), *radius)
        d = np.clip(d0 * log_uniform(rng, 1 / (1 + spread), 1 + spread, kinds), *density)
        which = np.arange(self.n) % kinds
        self.radius, self.mass = np.round(r[which], 5), None
        self.mass = np.array([float(f"{m:.4g}") for m in 4 / 3 * np.pi * self.radius**3 * d[which]])
        self.base.update(mass=self.mass, radius=self.radius)
        self.conditions.update({"mass [kg]": self.mass, "diameter [m]": 2 * self.radius})

    def sampling(self, rng, starts, ends, most=3000, least=30):
        """Times of the samples of each run: even, uneven, or with a gap."""
        count = int(np.clip(log_uniform(rng, least, 400), least, max(least, most / self.n)))
        self.jitter = 0.0
        style = rng.choice(["even", "uneven", "gap"], p=[0.6, 0.2, 0.2])
        out = []
        for a, b in zip(starts, ends):
            t = np.linspace(a, b, count)
            if style == "uneven":
                t = np.sort(np.concatenate([[a], rng.uniform(a, b, count - 1)]))
            if style == "gap":
                at = rng.uniform(0.2, 0.7)
                t = t[(np.linspace(0, 1, count) < at) | (np.linspace(0, 1, count) > at + 0.15)]
            out.append(np.round(t, 9))
        self.times = out
        if rng.random() < 0.15:
            self.jitter = float((ends[0] - starts[0]) / count * rng.uniform(0.02, 0.15))

    @property
    def groups(self):
        return {g: [c for c in self.channels if c in m] for g, m in GROUPS.items() if any(c in m for c in self.channels)}

    def span(self, group):
        return float(max(np.abs(s[self.channels.index(c)]).max() for s in self.plain for c in self.groups[group]))

    def knows_zero(self, group):
        return self.kind in ("contact",) or (self.kind == "bounce" and group == "position") or self.initial_state == "case"

    @property
    def time_scale(self):
        return self.contact_time if self.kind == "contact" else self.duration

    # --- the forward model ----------------------------------------------------------------------------------------------
    def start(self):
        return np.zeros((12, self.n))

    def lanes(self, variants):
        p, names = {}, set(self.base)
        for v in variants:
            names |= {k for k in v.get("params", {}) if ":" not in k and k != "drift"}
        from ball import OFF as ball_off
        from plane import OFF as plane_off
        off = {**ball_off, **plane_off}
        for name in names:
            p[name] = np.concatenate([np.broadcast_to(np.asarray(v.get("params", {}).get(name, self.base.get(name, off[name])), float), (self.n,))
                                      for v in variants])
        for i, v in enumerate(variants):
            drift = v.get("params", {}).get("drift", 0.0)
            for name in STIFFNESS:
                if drift and name in p:
                    p[name][i * self.n:(i + 1) * self.n] *= 1 + drift * (np.arange(self.n) / self.n - 0.5)
        y = np.tile(self.start(), (1, len(variants)))
        for i, v in enumerate(variants):
            for comp, shift in v.get("init", {}).items():
                if comp in ROW:
                    y[ROW[comp], i * self.n:(i + 1) * self.n] += shift
        return p, y

    def simulate(self, variants, hooks=None):
        rigid = [("tangential_compliance" in {**self.base, **v.get("params", {})}
                  and float(np.max({**self.base, **v.get("params", {})}["tangential_compliance"])) == 0) for v in variants]
        out = [None] * len(variants)
        for shear in ("rigid", "spring"):
            which = [i for i, r in enumerate(rigid) if r == (shear == "rigid")]
            if which:
                kind = self.shear if self.shear == "none" else shear
                for i, s in zip(which, self.simulate_alike([variants[i] for i in which], hooks, kind)):
                    out[i] = s
        return out

    def simulate_alike(self, variants, hooks, shear):
        p, y = self.lanes(variants)
        balls = Balls(p, len(y[0]), law=self.law, wall=self.kind != "flight", shear=shear, strange=hooks)
        path = balls.run(y, np.tile(self.ends, len(variants)), flight_step=self.flight_step, contact_steps=self.contact_steps,
                         starts_touching=self.kind in ("contact", "oblique"))
        self.path = path
        return [[self.measure(balls, path, i * self.n + r, r, v, hooks) for r in range(self.n)] for i, v in enumerate(variants)]

    def raw(self, balls, path, lane, times):
        y, deep, touched = path.at(lane, times)
        rows = []
        for c in self.channels:
            rows.append(y[ROW[c]])
        return np.array(rows)

    def measure(self, balls, path, lane, run, variant, hooks):
        """The channels of one run as the instrument of this variant shows them."""
        times, params = self.times[run], variant.get("params", {})
        instrument = {tuple(k.split(":")[1:]): v for k, v in params.items() if k.startswith("instrument:")}
        out = self.raw(balls, path, lane, times)
        if getattr(path, "failed", None) is not None and path.failed[lane]:
            out = out * np.nan
        for (what, group), value in instrument.items():
            rows = [self.channels.index(c) for c in self.groups[group]]
            if what == "shift":
                out[rows] = self.raw(balls, path, lane, times - value)[rows]
            if what == "lag":
                fine = np.linspace(times[0], times[-1], 4001)
                out[rows] = [np.interp(times, fine, first_order(s, fine[1] - fine[0], value)) for s in self.raw(balls, path, lane, fine)[rows]]
            if what == "gain":
                out[rows] *= value
            if what == "offset":
                out[rows] += value
            if what == "saturation":
                out[rows] = np.clip(out[rows], -value, value)
        if hooks and "signal" in hooks:
            out[self.channels.index("force")] += float(np.max(params.get("strange", 0.0))) * hooks["signal"](times)
        return out


def first_order(signal, dt, lag):
    """tau y' = s - y from y = s at the start, exact for a signal that is straight between its points."""
    a = np.exp(-dt / lag)
    mean = (1 - a) * lag / dt
    drive = np.concatenate([[0], (mean - a) * signal[:-1] + (1 - mean) * signal[1:]])
    start = signal[0]
    return lfilter([1], [1, -a], drive, zi=[start])[0] if start else lfilter([1], [1, -a], drive)


def pick(balls, lane, n):
    """The numbers of one lane, for n states of it."""
    one = Balls.__new__(Balls)
    one.p = {k: np.full(n, v[lane]) for k, v in balls.p.items()}
    one.law, one.strange, one.shear = balls.law, balls.strange, balls.shear
    one.has = balls.has
    one.rupture, one.neck, one.beta = np.full(n, balls.rupture[lane]), np.full(n, balls.neck[lane]), np.full(n, balls.beta[lane])
    return one


def soften(e, rng, wanted):
    """Stiffness for which the mean ball's contact lasts `wanted` at the reference speed; scales of the contact."""
    m, R, v = float(e.mass.mean()), float(e.radius.mean()), e.reference_speed
    if e.law == "linear":
        e.base["normal_stiffness"] = k = float(f"{m * (np.pi / wanted) ** 2:.4g}")
        e.times_of_contact = np.pi * np.sqrt(e.mass / k)
        e.deepest = v * np.sqrt(m / k)
        e.peak_force = k * e.deepest
        e.base["tangential_ratio"] = 2 / 3
    else:
        deepest = v * wanted / 2.94
        e.poisson = float(np.round(rng.uniform(0.2, 0.4), 2))
        if e.law == "power_law":
            r = e.base["stiffness_exponent"] = float(np.round(rng.uniform(1.3, 1.8), 2))
            s = e.base["damping_exponent"] = float(np.round(rng.uniform(0.4, 1.0), 2))
            k = e.base["stiffness_coefficient"] = float(f"{(r + 1) / 2 * m * v * v / deepest ** (r + 1):.4g}")
            e.base["damping_coefficient"] = float(f"{rng.uniform(0.1, 0.4) * np.sqrt(m * k * deepest ** (r - 1)) / deepest ** s:.4g}")
            slow = (((r + 1) * e.mass * e.speed**2 / (2 * k)) ** (1 / (r + 1))) / e.speed
            e.times_of_contact, e.peak_force = 3.0 * slow, k * deepest**r
        else:
            E = 15 * m * v * v / (16 * np.sqrt(R) * deepest**2.5)
            e.young = float(f"{E * (1 - e.poisson**2):.4g}")
            e.base["effective_young"] = E = e.young / (1 - e.poisson**2)
            e.base["effective_shear"] = e.young / (2 * (2 - e.poisson) * (1 + e.poisson))
            speed = getattr(e, "speed", np.full(e.n, v))
            e.times_of_contact = 2.94 * (15 * e.mass / (16 * E * np.sqrt(e.radius))) ** 0.4 / speed**0.2
            e.peak_force = 4 / 3 * E * np.sqrt(R) * deepest**1.5
            e.peak_pressure = 2 * E / np.pi * np.sqrt(deepest / R)
        e.deepest = deepest
    e.contact_time = wanted


def stand_on_plane(e):
    """Stiff enough that the contact is rigid for the recording; where the ball rests."""
    e.stiffness = float(f"{e.mass.max() * (np.pi / 4e-3) ** 2:.4g}")
    e.conditions["z0 [m]"] = e.radius - 9.81 * e.mass / e.stiffness
