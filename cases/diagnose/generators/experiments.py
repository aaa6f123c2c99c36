"""Random experiments: bodies, runs, what is measured and what may be calibrated. One class per kind."""
import numpy as np

from experiment import Experiment, log_uniform, pick, soften, stand_on_plane
from plane import Rollers


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
        # Deeper than a twentieth of the radius the lever arm of friction is a matter of definition.
        soften(self, rng, min(rng.uniform(1.2e-3, 2.5e-3), 0.05 * np.pi * self.radius.min() / self.reference_speed))
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
        stand_on_plane(self)
        arm = self.conditions["z0 [m]"]
        style = rng.choice(["slides", "rolls", "back_spin"])
        self.w0 = {"slides": 0 * self.v0, "rolls": self.v0 / arm, "back_spin": -rng.uniform(0, 0.5, self.n) * self.v0 / self.radius}[style]
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

    def simulate(self, variants, hooks=None):
        p, _ = self.lanes(variants)
        y = np.tile(np.stack([0 * self.v0, self.v0, self.w0, 0 * self.v0]), (1, len(variants)))
        for i, v in enumerate(variants):
            for comp, shift in v.get("init", {}).items():
                y[{"x": 0, "vx": 1, "wy": 2, "wz": 3}[comp], i * self.n:(i + 1) * self.n] += shift
        rollers = Rollers(p, y.shape[1], self.stiffness, strange=hooks)
        if self.style == "rolls":  # a ball released rolling stays so: its spin follows its speed
            y[2] = y[1] / rollers.arm
        rollers.run(y, self.duration)
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
        rollers = Rollers(p, y.shape[1], self.stiffness, strange=hooks).run(y, self.duration)
        return [[self.measure(None, rollers, i * self.n + r, r, v, None) for r in range(self.n)] for i, v in enumerate(variants)]


KINDS = {"flight": Flight, "bounce": Bounce, "impact_times": ImpactTimes, "contact": Contact, "oblique": Oblique, "roll": Roll, "spin": Spin}
