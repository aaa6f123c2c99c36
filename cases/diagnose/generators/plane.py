"""A ball that slides, rolls or spins on a level plane: rigid Coulomb friction, many balls at a time.

x'' and wy' while sliding; v = R wy once the sliding has ended; rest when rolling resistance has stopped it. wz apart.
"""
import numpy as np

OFF = {"mass": 0.05, "radius": 0.02, "gz": -9.81, "friction": 0.3, "rolling_friction": 0.0, "torsional_friction": 0.0,
       "fluid_density": 1.2, "fluid_viscosity": 1.8e-5, "drag_coefficient": 0.0, "viscous_drag": 0.0, "buoyancy": 0.0,
       "added_mass": 0.0, "strange": 0.0}
SLIDES, ROLLS, RESTS = 0, 1, 2


class Rollers:
    def __init__(self, p, lanes, stiffness, strange=None):
        self.p = q = {k: np.broadcast_to(np.asarray(p.get(k, off), float), (lanes,)) for k, off in OFF.items()}
        self.lanes, self.strange = lanes, strange or {}
        self.volume, self.area = 4 / 3 * np.pi * q["radius"] ** 3, np.pi * q["radius"] ** 2
        self.inertia = q["mass"] + q["added_mass"] * q["fluid_density"] * self.volume
        self.gyration = 0.4 * q["mass"] * q["radius"] ** 2
        self.weight = -q["gz"] * (q["mass"] - q["buoyancy"] * self.volume)
        self.arm = q["radius"] - self.weight / stiffness  # from the centre to the plane, as the contact yields

    def slope(self, t, y, mode):
        q = self.p
        x, v, w, wz = y
        c = 0.5 * q["fluid_density"] * self.area * q["drag_coefficient"]
        push = -(c * np.abs(v) + 6 * np.pi * q["viscous_drag"] * q["radius"]) * v
        if "field" in self.strange:
            push = push + self.strange["field"](t, x, v, q)
        slip = v - self.arm * w
        mu = self.strange["friction"](np.abs(slip), q) if "friction" in self.strange else q["friction"]
        mu_r = self.strange["rolling"](x, v, q) if "rolling" in self.strange else q["rolling_friction"]
        moment = -mu_r * q["radius"] * self.weight * np.where(w == 0, self.way, np.sign(w))
        grip = -mu * self.weight * self.way
        rolling = (push + moment / self.arm) / (self.inertia + self.gyration / self.arm ** 2)
        dv = np.where(mode == SLIDES, (push + grip) / self.inertia, np.where(mode == ROLLS, rolling, 0.0))
        dw = np.where(mode == SLIDES, (moment - self.arm * grip) / self.gyration, np.where(mode == ROLLS, rolling / self.arm, 0.0))
        drill = -q["torsional_friction"] * q["radius"] * self.weight * np.tanh(wz / 1e-4)
        if "drill" in self.strange:
            drill = drill + self.strange["drill"](wz, q)
        return np.stack([np.where(mode == RESTS, 0.0, v), dv, dw, drill / self.gyration])

    def run(self, y, t_end, steps=300):
        q, L = self.p, self.lanes
        y = np.array(y, float)
        slip = y[1] - self.arm * y[2]
        grippy = q["friction"] > 0  # without friction nothing makes a ball roll, or keeps it rolling
        mode = np.where((np.abs(slip) > 1e-9) | ~grippy, SLIDES, ROLLS)
        t, ts, ys, ds = np.zeros(L), [], [], []
        while True:
            h = np.minimum(t_end / steps, t_end - t)
            self.way = np.sign(y[1] - self.arm * y[2])  # of the sliding, for the whole of a step
            k1 = self.slope(t, y, mode)
            ts.append(t.copy()), ys.append(y.copy()), ds.append(k1.copy())
            if (h <= 1e-12).all():
                break

            def step(h):
                k2 = self.slope(t + h / 2, y + h / 2 * k1, mode)
                k3 = self.slope(t + h / 2, y + h / 2 * k2, mode)
                k4 = self.slope(t + h, y + h * k3, mode)
                return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            new = step(h)
            u0, u1 = y[1] - self.arm * y[2], new[1] - self.arm * new[2]
            grips = (mode == SLIDES) & grippy & (u0 * u1 < 0)
            stops = (mode == ROLLS) & (y[1] * new[1] < 0)
            drilled = (y[3] != 0) & (y[3] * new[3] <= 0)
            turns = (mode == SLIDES) & ~grips & (y[2] * new[2] < 0)
            if (grips | stops | drilled | turns).any():
                with np.errstate(all="ignore"):
                    part = np.where(grips, u0 / (u0 - u1), np.where(stops, y[1] / (y[1] - new[1]), np.where(drilled, y[3] / (y[3] - new[3]), np.where(turns, y[2] / (y[2] - new[2]), 1.0))))
                h = h * np.clip(part, 0, 1)
                new = step(h)
                v = np.where(grips, (self.inertia * new[1] * self.arm + self.gyration * new[2]) /
                             (self.inertia * self.arm + self.gyration / self.arm), new[1])
                new[1], new[2] = np.where(stops, 0.0, v), np.where(grips, v / self.arm, np.where(stops | turns, 0.0, new[2]))
                new[3] = np.where(drilled, 0.0, new[3])
                mode = np.where(grips, ROLLS, np.where(stops, RESTS, mode))
            y, t = new, t + h
        self.t, self.y, self.d = np.array(ts), np.array(ys), np.array(ds)
        return self

    def at(self, lane, times):
        from ball import hermite
        t = self.t[:, lane]
        keep = np.concatenate([[True], np.diff(t) > 1e-13])
        t, y, d = t[keep], self.y[keep, :, lane], self.d[keep, :, lane]
        times = np.clip(times, t[0], t[-1])
        i = np.clip(np.searchsorted(t, times, "right") - 1, 0, len(t) - 2)
        h = t[i + 1] - t[i]
        s = (times - t[i]) / h
        return hermite(s, y[i].T, y[i + 1].T, h * d[i].T, h * d[i + 1].T)
