"""Random experiments: bodies, runs, sampling, what is measured and what may be calibrated; their forward model for many variants at once.

A variant is {"params": {number: value or one per run}, "init": {component: shift}}; the result is signals[variant][run][channel, sample].
"""
import numpy as np
from scipy.signal import lfilter

import laws
from ball import Balls
from plane import Rollers

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


class Flight(Experiment):
    kind, flight_step, contact_steps = "flight", 0.01, 1

    def __init__(self, rng):
        self.common(rng)
        shape = rng.choice(["z", "xz", "xyz"], p=[0.45, 0.25, 0.3])
        self.fluid_density = float(rng.choice([1.2, 1000.0], p=[0.75, 0.25]))
        self.base.update(fluid_density=self.fluid_density, fluid_viscosity=1.8e-5 if self.fluid_density < 10 else 1e-3)
        self.sizes(rng, (0.005, 0.06), (40, 8000) if self.fluid_density < 10 else (1100, 8000))
        self.duration = T = float(np.round(rng.uniform(0.4, 2.0) * (1 if self.fluid_density < 10 else 0.5), 3))
        self.spins = shape == "xyz"
        self.schiller = rng.random() < 0.25
        u = rng.uniform
        self.v0 = np.zeros((3, self.n))
        self.v0[2] = u(-2, 2, self.n) if shape == "z" else u(0, 8, self.n)
        self.w0 = np.zeros((3, self.n))
        if shape != "z":
            self.v0[0] = u(2, 15, self.n)
        if self.spins:
            self.v0[1] = u(-3, 3, self.n)
            self.w0[1], self.w0[2] = u(-80, 80, self.n), u(-80, 80, self.n)
            self.conditions.update({f"w{a}0 [rad/s]": self.w0[i] for i, a in enumerate("xyz")})
        self.z0 = u(1, 3, self.n) + 5 * T * T
        self.channels = list(shape)
        if rng.random() < 0.2:
            self.channels += ["v" + c for c in shape]
        self.init = list(shape) + ["v" + c for c in shape]
        self.ends = np.full(self.n, T)
        self.reference_speed = float(9.81 * T if shape == "z" else np.mean(np.abs(self.v0[0])) + 5 * T)
        self.height, self.middle = 4.9 * T * T, float(np.mean(self.z0) - 2 * T * T)
        if rng.random() < 0.3:
            self.base["drag_coefficient"] = float(np.round(u(0.1, 0.6), 2))
            self.free.append(("medium.drag_coefficient", "drag_coefficient", [0, 3]))
            self.schiller = False
        self.sampling(rng, np.zeros(self.n), self.ends)
        s = log_uniform(rng, 3e-4, 6e-3)
        self.sd = {c: float(s if len(c) == 1 else s * 10) for c in self.channels}

    def start(self):
        y = np.zeros((12, self.n))
        y[2], y[3:6], y[6:9] = self.z0, self.v0, self.w0
        return y


class Bounce(Experiment):
    kind, flight_step, contact_steps = "bounce", 1e-2, 50

    def __init__(self, rng, events=False):
        self.common(rng)
        self.law = rng.choice(["linear", "hertz_mindlin"], p=[0.35, 0.65])
        self.contact_steps = 50 if self.law == "linear" else 80
        self.sizes(rng, (0.012, 0.035), (40, 8000), spread=0.4)
        self.base["restitution"] = float(np.round(rng.uniform(0.65, 0.94), 3))
        drop = np.round(rng.uniform(0.1, 0.6, self.n), 4)
        self.z0 = self.radius + drop
        self.reference_speed = float(np.sqrt(2 * 9.81 * drop.max()))
        soften(self, rng, rng.uniform(2.5e-3, 4.5e-3))
        self.free.append(("pair.ball.plate.restitution", "restitution", [0.3, 0.995]))
        self.height = float(drop.mean())
        self.middle = float(drop.mean() / 2)
        self.channels = ["z"] + (["vz"] if rng.random() < 0.25 else [])
        known = events or rng.random() < 0.5
        if known:
            self.conditions["drop_height [m]"] = drop
            self.initial_state = "case"
        else:
            self.init = ["z", "vz"]
        self.knows_time = known and not events
        # How long: some bounces, and not down to the last small ones.
        e, fall = self.base["restitution"], np.sqrt(2 * drop / 9.81)
        most = 1 + np.floor(np.log(0.45 / np.sqrt(2 * 9.81 * drop)) / np.log(e)).astype(int)
        self.bounces = np.clip(most, 2, int(rng.integers(3, 12) if events else rng.integers(2, 8)))
        self.ends = np.array([f * (1 + 2 * sum(e**k for k in range(1, b + 1))) for f, b in zip(fall, self.bounces)])
        self.ends *= rng.uniform(0.9, 1.0) if not events else 1.0
        self.duration = float(self.ends.max())
        self.sampling(rng, np.zeros(self.n), self.ends)
        s = log_uniform(rng, 5e-4, 5e-3)
        self.sd = {c: float(s if len(c) == 1 else s * 20) for c in self.channels}

    def start(self):
        y = np.zeros((12, self.n))
        y[2] = self.z0
        return y


class ImpactTimes(Bounce):
    kind = "impact_times"

    def __init__(self, rng):
        super().__init__(rng, events=True)
        self.channels, self.init, self.jitter = ["impact_time"], ["clock"], 0.0
        self.times = [np.arange(1, b + 1) for b in self.bounces]
        self.sd = {"impact_time": float(log_uniform(rng, 3e-4, 3e-3))}
        self.ends = self.ends + 0.15

    @property
    def groups(self):
        return {}

    def measure(self, balls, path, lane, run, variant, hooks):
        t = np.array(path.touches[lane][:len(self.times[run])])
        if path.failed[lane] or len(t) < len(self.times[run]):
            return np.full((1, len(self.times[run])), np.nan)
        return (t + np.broadcast_to(variant.get("init", {}).get("clock", 0.0), (self.n,))[run])[None, :]


class Contact(Experiment):
    kind, flight_step, contact_steps, knows_time, initial_state = "contact", 1e-3, 120, True, "case"

    def __init__(self, rng):
        self.common(rng, 4, 12)
        self.initial_state = "case"
        self.law = rng.choice(["linear", "hertz_mindlin", "power_law"], p=[0.4, 0.4, 0.2])
        self.sizes(rng, (0.005, 0.03), (1000, 8000))
        self.speed = np.round(rng.uniform(0.3, 4, self.n), 3)
        self.conditions["impact_speed [m/s]"] = self.speed
        self.reference_speed = float(self.speed.max())
        self.base["restitution"] = float(np.round(rng.uniform(0.45, 0.93), 3))
        soften(self, rng, log_uniform(rng, 1e-4, 2e-3))
        if self.law == "power_law":
            self.free += [("pair.ball.plate.stiffness_coefficient", "stiffness_coefficient", None),
                          ("pair.ball.plate.damping_coefficient", "damping_coefficient", None)]
        else:
            self.free += [("pair.ball.plate.restitution", "restitution", [0.2, 0.995]),
                          ("pair.ball.plate.normal_stiffness", "normal_stiffness", None) if self.law == "linear" else
                          ("material.ball.young", "effective_young", None)]
        self.channels = [["force"], ["displacement"], ["force", "displacement"]][rng.choice(3, p=[0.5, 0.15, 0.35])]
        T = self.contact_time
        self.ends = np.array([1.5 * t for t in np.broadcast_to(self.times_of_contact, (self.n,))])
        self.duration = float(self.ends.max())
        self.sampling(rng, -0.15 * self.ends, self.ends)
        if self.jitter:
            self.jitter = min(self.jitter, 0.005 * T)
        self.sd = {c: float(log_uniform(rng, 0.005, 0.03) * (self.peak_force if c == "force" else self.deepest)) for c in self.channels}
        self.height = self.deepest

    def start(self):
        y = np.zeros((12, self.n))
        y[2], y[5] = self.radius, -self.speed
        return y

    def raw(self, balls, path, lane, times):
        y, deep, touched = path.at(lane, times)
        rows, before = [], np.asarray(times) < 0
        one = pick(balls, lane, len(times))
        push, _ = one.normal(y, touched & ~before, np.maximum(deep, one.p["radius"] - y[2] - y[11]), one.beta)
        for c in self.channels:
            rows.append(np.where(before, 0.0, push) if c == "force" else np.where(before, -y[5] * times, balls.p["radius"][lane] - y[2]))
        return np.array(rows)


class Oblique(Experiment):
    kind, flight_step, contact_steps, knows_time = "oblique", 5e-3, 150, False

    def __init__(self, rng):
        self.common(rng, 8, 24)
        self.initial_state = "case"
        self.law = rng.choice(["linear", "hertz_mindlin"])
        self.sizes(rng, (0.008, 0.025), (1000, 8000), spread=0.3)
        self.speed = np.round(rng.uniform(1, 4, self.n) if rng.random() < 0.5 else np.full(self.n, rng.uniform(1, 4)), 3)
        self.angle = np.round(np.linspace(5, rng.uniform(55, 82), self.n), 2)
        self.conditions.update({"impact_speed [m/s]": self.speed, "impact_angle [deg]": self.angle})
        self.reference_speed = float(self.speed.max())
        self.base["restitution"] = float(np.round(rng.uniform(0.6, 0.95), 3))
        self.base["friction"] = float(np.round(rng.uniform(0.06, 0.35), 3)) if rng.random() < 0.85 else 0.0
        self.base["tangential_compliance"] = float(rng.choice([0.0, 1.0]))
        soften(self, rng, rng.uniform(1.2e-3, 2.5e-3))
        self.free.append(("pair.ball.plate.restitution", "restitution", [0.3, 0.995]))
        if self.base["friction"]:
            self.free.append(("pair.ball.plate.friction", "friction", [0.01, 1.0]))
        self.shear = "spring"
        T = self.times_of_contact / np.cos(np.radians(self.angle)) ** (0.2 if self.law != "linear" else 0)
        self.channels = ["vx", "vz", "wy"] if rng.random() < 0.7 else ["vx", "wy"]
        self.ends = 1.6 * T + 0.01
        self.duration = float(self.ends.max())
        self.jitter, count = 0.0, int(rng.integers(3, 12))
        self.times = [np.round(np.linspace(1.6 * t, e, count), 8) for t, e in zip(T, self.ends)]
        self.sd = {"vx": float(log_uniform(rng, 0.003, 0.03)), "vz": float(log_uniform(rng, 0.003, 0.03)),
                   "wy": float(log_uniform(rng, 0.003, 0.02) * self.reference_speed / self.radius.mean())}
        self.height = 0.02

    def start(self):
        y = np.zeros((12, self.n))
        a = np.radians(self.angle)
        y[2], y[3], y[5] = self.radius, self.speed * np.sin(a), -self.speed * np.cos(a)
        return y


class Roll(Experiment):
    kind = "roll"

    def __init__(self, rng):
        self.common(rng)
        self.sizes(rng, (0.01, 0.04), (100, 8000))
        self.duration = T = float(np.round(rng.uniform(0.5, 2.5), 3))
        self.v0 = np.round(rng.uniform(0.6, 3, self.n), 4)
        style = rng.choice(["slides", "rolls", "back_spin"])
        self.w0 = {"slides": 0 * self.v0, "rolls": self.v0 / self.radius, "back_spin": -rng.uniform(0, 0.5, self.n) * self.v0 / self.radius}[style]
        mu = float(np.round(rng.uniform(0.03, 0.35), 3))
        self.base["friction"] = mu if rng.random() < 0.85 else 0.0
        if style != "rolls" and self.base["friction"]:
            self.free.append(("pair.ball.plate.friction", "friction", [0.005, 1.0]))
        if rng.random() < 0.3:
            self.base["rolling_friction"] = float(np.round(rng.uniform(0.001, 0.01), 4))
            self.free.append(("pair.ball.plate.rolling_friction", "rolling_friction", [0, 0.2]))
        self.style = style
        self.channels = [["x"], ["x", "wy"], ["vx", "wy"]][rng.choice(3)]
        self.reference_speed = float(self.v0.max())
        self.height = 1.0
        self.ends = np.full(self.n, T)
        self.sampling(rng, np.zeros(self.n), self.ends)
        s = log_uniform(rng, 3e-4, 3e-3)
        self.sd = {c: float({"x": s, "vx": 8 * s, "wy": 8 * s / self.radius.mean()}[c]) for c in self.channels}
        self.init = {"x": ["x", "vx"], "vx": ["vx"]}[self.channels[0]] + ["wy"]
        if "wy" not in self.channels:
            self.init.remove("wy")
            self.conditions["wy0 [rad/s]"] = self.w0
        stand_on_plane(self)

    def simulate(self, variants, hooks=None):
        p, _ = self.lanes(variants)
        y = np.tile(np.stack([0 * self.v0, self.v0, self.w0, 0 * self.v0]), (1, len(variants)))
        for i, v in enumerate(variants):
            for comp, shift in v.get("init", {}).items():
                y[{"x": 0, "vx": 1, "wy": 2, "wz": 3}[comp], i * self.n:(i + 1) * self.n] += shift
        if self.style == "rolls":  # a ball released rolling stays so: its spin follows its speed
            y[2] = y[1] / np.tile(self.radius, len(variants))
        rollers = Rollers(p, y.shape[1], strange=hooks).run(y, self.duration)
        return [[self.measure(None, rollers, i * self.n + r, r, v, None) for r in range(self.n)] for i, v in enumerate(variants)]

    def raw(self, balls, path, lane, times):
        y = path.at(lane, times)
        return np.array([y[{"x": 0, "vx": 1, "wy": 2, "wz": 3}[c]] for c in self.channels])


class Spin(Roll):
    kind = "spin"

    def __init__(self, rng):
        self.common(rng)
        self.sizes(rng, (0.01, 0.04), (500, 8000))
        self.duration = T = float(np.round(rng.uniform(0.5, 3), 3))
        self.base["friction"] = 0.3
        self.w = np.round(rng.uniform(30, 300, self.n), 2)
        self.reference_spin, self.reference_speed, self.height, self.style = float(self.w.max()), 1.0, 1.0, "spins"
        if rng.random() < 0.5:
            self.base["torsional_friction"] = float(np.round(rng.uniform(0.001, 0.02), 4))
            self.free.append(("pair.ball.plate.torsional_friction", "torsional_friction", [0, 0.3]))
        self.v0 = self.w0 = np.zeros(self.n)
        self.channels, self.init = ["wz"], ["wz"]
        self.ends = np.full(self.n, T)
        self.sampling(rng, np.zeros(self.n), self.ends)
        self.sd = {"wz": float(log_uniform(rng, 0.05, 2))}
        stand_on_plane(self)

    def simulate(self, variants, hooks=None):
        p, _ = self.lanes(variants)
        y = np.tile(np.stack([self.v0, self.v0, self.v0, self.w]), (1, len(variants)))
        for i, v in enumerate(variants):
            y[3, i * self.n:(i + 1) * self.n] += v.get("init", {}).get("wz", 0.0)
        rollers = Rollers(p, y.shape[1], strange=hooks).run(y, self.duration)
        return [[self.measure(None, rollers, i * self.n + r, r, v, None) for r in range(self.n)] for i, v in enumerate(variants)]


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


KINDS = {"flight": Flight, "bounce": Bounce, "impact_times": ImpactTimes, "contact": Contact, "oblique": Oblique, "roll": Roll, "spin": Spin}
