"""One ball over a plane z = 0, many at a time (lanes), each with its own clock and step: RK4 with located events.

Lanes differ in their numbers, never in the law. A path keeps every step with its slope, so that states between steps
come from Hermite's cubic. Not shared with quern: the equations are written down anew.
"""
import numpy as np
import laws

X, V, W, S, U = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 11), 11  # place, velocity, spin, tangential stretch, rod's end
SIZE = 12
FREE, NEAR = 0, 1
OFF = {  # every number that a lane may have, with the value that switches it off
    "mass": 0.01, "radius": 0.01, "gx": 0.0, "gz": -9.81,
    "fluid_density": 1.2, "fluid_viscosity": 1.8e-5,
    "drag_coefficient": 0.0, "viscous_drag": 0.0, "buoyancy": 0.0, "added_mass": 0.0, "magnus": 0.0, "schiller_naumann": 0.0,
    "normal_stiffness": 1e4, "tangential_ratio": 2 / 3, "effective_young": 1e7, "effective_shear": 3e6,
    "stiffness_coefficient": 1.0, "stiffness_exponent": 1.6, "damping_coefficient": 0.0, "damping_exponent": 0.8,
    "restitution": 1.0, "friction": 0.0, "tangential_compliance": 1.0,
    "restitution_exponent": 0.0, "reference_speed": 1.0, "viscoelastic_time": 0.0,
    "unloading_ratio": 1.0, "yield_pressure": np.inf, "hardening": 0.0, "stiffness_power": 0.0, "reference_overlap": 1e-4,
    "surface_energy": 0.0, "bridge_volume": 0.0, "surface_tension": 0.0728, "wetting_angle": 0.0,
    "film_viscosity": 0.0, "film_thickness": 0.0, "film_cutoff": 1e-5, "wave_admittance": 0.0, "powder_layers": 0.0,
    "strange": 0.0,  # strength of an effect outside the catalogue
}


def schiller_naumann(re):
    re = np.maximum(re, 1e-12)
    return np.where(re < 1000, 24 / re * (1 + 0.15 * re**0.687), 0.44)


class Balls:
    """`p`: numbers by name (scalars or one per lane). `shear`: "none", "spring" or "rigid". `strange`: hooks of an effect outside the catalogue."""

    def __init__(self, p, lanes, law="linear", wall=True, shear="none", strange=None):
        self.p = {k: np.broadcast_to(np.asarray(p.get(k, off), float), (lanes,)) for k, off in OFF.items()}
        self.law, self.wall, self.shear, self.lanes = law, wall, shear, lanes
        self.strange = strange or {}
        q = self.p
        self.volume, self.area = 4 / 3 * np.pi * q["radius"] ** 3, np.pi * q["radius"] ** 2
        self.inertia = q["mass"] + q["added_mass"] * q["fluid_density"] * self.volume
        self.gyration = 0.4 * q["mass"] * q["radius"] ** 2
        self.reach = np.where(q["film_viscosity"] != 0, q["film_thickness"], 0.0)
        self.rupture = np.where(q["bridge_volume"] > 0, laws.bridge_rupture(q), 0.0)
        self.neck = np.where(q["surface_energy"] > 0, -laws.neck_breaks_at(q), 0.0)
        self.drag, self.stokes = 0.5 * q["fluid_density"] * self.area * q["drag_coefficient"], 6 * np.pi * q["viscous_drag"] * q["radius"]
        self.weight = q["mass"] * q["gz"] * (1 - q["buoyancy"] * self.volume / q["mass"])
        self.has = {k for k, off in OFF.items() if (q[k] != off).any()}
        self.touched = np.zeros(lanes, bool)
        self.deepest = np.zeros(lanes)
        self.beta = np.full(lanes, laws.damping_ratio(law, 1.0)) if law == "power_law" else laws.damping_ratio(law, q["restitution"])

    # --- forces -------------------------------------------------------------------------------------------------------
    def field(self, t, y):
        """Force of gravity and of the fluid, without contacts."""
        q, v, w = self.p, y[V], y[W]
        f = np.zeros((3, y.shape[1]))
        f[0] = q["mass"] * q["gx"]
        f[2] = self.weight
        speed = np.sqrt((v**2).sum(0))
        c = self.drag
        if "schiller_naumann" in self.has:
            c = c * schiller_naumann(q["fluid_density"] * speed * 2 * q["radius"] / q["fluid_viscosity"])
        f -= (c * speed + self.stokes) * v
        if "magnus" in self.has:
            f += q["magnus"] * q["fluid_density"] * np.pi * q["radius"] ** 3 * np.cross(w, v, axis=0)
        if "field" in self.strange:
            f += self.strange["field"](t, y, q)
        return f

    def normal(self, y, touched, deepest, beta, resting=False):
        """Force of the wall on the ball along z, and how fast the rod's end gives way."""
        q, law = self.p, self.law
        gap = y[2] - q["radius"] + y[U]
        overlap = np.maximum(-gap, 0)
        rate = -y[5]
        elastic, slope = laws.spring(law, q, overlap)
        damping = laws.dashpot(law, q, overlap, slope, beta)
        if "yield_pressure" in self.has:
            elastic = np.where(np.isfinite(q["yield_pressure"]), laws.yielding(q, overlap, deepest), elastic)
        if "unloading_ratio" in self.has:  # Walton & Braun (1986) on the linear law
            ratio = q["unloading_ratio"]
            back = q["normal_stiffness"] * (deepest - ratio * (deepest - overlap))
            elastic = np.where((overlap < deepest) & (ratio != 1), np.maximum(back, 0), elastic)
        if "hardening" in self.has:
            elastic = elastic * (1 + q["hardening"] * overlap)
        if "stiffness_power" in self.has:
            elastic = elastic * np.maximum(overlap / q["reference_overlap"], 1e-12) ** q["stiffness_power"]
        if "powder_layers" in self.has:
            elastic, damping = elastic / (1 + q["powder_layers"]), damping * (1 + q["powder_layers"])
        if "viscoelastic_time" in self.has:
            damping = damping + q["viscoelastic_time"] * slope
        if "elastic" in self.strange:
            elastic = elastic + self.strange["elastic"](overlap, rate, q)
        give = q["wave_admittance"]
        push = np.maximum((elastic + damping * rate) / (1 + damping * give), 0) if not resting else elastic
        push = np.where(gap < 1e-11, push, 0.0)
        if "surface_energy" in self.has:
            sticky = q["surface_energy"] > 0
            force, a = laws.jkr(q, -gap)
            force = force + laws.dashpot(law, q, a * a / q["radius"], 2 * q["effective_young"] * a, beta) * rate
            push = np.where(sticky, np.where(touched & (gap < self.neck), force, 0.0), push)
        if "bridge_volume" in self.has:
            push = push - np.where(touched & (gap < self.rupture), laws.bridge_pull(q, gap), 0.0)
        if "film_viscosity" in self.has:
            near = gap < q["film_thickness"]
            push = push + np.where(near, 6 * np.pi * q["film_viscosity"] * q["radius"] ** 2 * rate / np.maximum(gap, q["film_cutoff"]), 0.0)
        if "stick" in self.strange:
            push = push + self.strange["stick"](y, gap, touched, q)
        return push, give * push

    def tangential(self, y, push, beta):
        """Force of the wall on the ball in its plane and the slopes of the stretch (spring), or just the sliding force (rigid)."""
        q = self.p
        overlap = np.maximum(q["radius"] - y[2] - y[U], 0)
        arm = q["radius"] - overlap
        slip = np.stack([y[3] - arm * y[7], y[4] + arm * y[6]])
        friction = q["friction"]
        if "friction" in self.strange:
            friction = self.strange["friction"](np.sqrt((slip**2).sum(0)), q)
        limit = friction * np.maximum(push, 0)
        if self.shear == "rigid":
            size = np.sqrt((slip**2).sum(0))
            return -limit * slip / np.maximum(size, 1e-9), np.zeros_like(slip), arm, slip
        _, slope = laws.spring(self.law, q, overlap)
        shear = (slope * q["tangential_ratio"] if self.law == "linear" else slope * 4 * q["effective_shear"] / q["effective_young"])
        shear = shear / np.maximum(q["tangential_compliance"], 1e-6)
        damping = 2 * (1.0 if self.law == "linear" else laws.SQRT56) * beta * np.sqrt(shear * q["mass"])
        stretch = y[S]
        trial = shear * stretch + damping * slip
        size = np.sqrt((trial**2).sum(0))
        slides = size > limit
        force = -trial * np.where(slides, limit / np.maximum(size, 1e-30), 1.0)
        # Mindlin's spring stiffens with the overlap: the stiffening alone does not raise its force.
        grow = slip - (0 if self.law == "linear" else stretch * np.maximum(-y[5], 0) / (2 * np.maximum(overlap, 1e-12)))
        return force, grow, arm, (slides, limit, shear, trial, size)

    def slope(self, t, y, near):
        q = self.p
        f = self.field(t, y)
        d = np.zeros_like(y)
        d[X] = y[V]
        if self.wall and near.any():
            push, give = self.normal(y, self.touched, self.deepest, self.beta)
            push, give = np.where(near, push, 0.0), np.where(near, give, 0.0)
            f[2] += push
            d[U] = give
            if self.shear != "none":
                force, grow, arm, _ = self.tangential(y, push, self.beta)
                force = np.where(near & self.touched, force, 0.0)
                f[0] += force[0]
                f[1] += force[1]
                d[6] = arm * force[1] / self.gyration
                d[7] = -arm * force[0] / self.gyration
                if self.shear == "spring":
                    d[S] = np.where(near & self.touched, grow, 0.0)
        d[V] = f / self.inertia
        # The gap's rate includes the rod's end: the spring feels z + u.
        return d

    # --- integration --------------------------------------------------------------------------------------------------
    def begin_contact(self, mask, speed):
        q = self.p
        self.touched = self.touched | mask
        if self.law != "power_law":
            e = q["restitution"]
            falls = 1 - (1 - e) * np.maximum(speed / q["reference_speed"], 1e-3) ** q["restitution_exponent"]
            e = np.where(q["restitution_exponent"] != 0, np.clip(falls, 0.15, 1), e)
            if "restitution" in self.strange:
                e = np.clip(self.strange["restitution"](e, speed, q), 0.15, 1)
            self.beta = np.where(mask, laws.damping_ratio(self.law, e), self.beta)

    def run(self, y, t_end, flight_step=5e-3, contact_steps=80, starts_touching=False, most=3500):
        """Follows every lane to t_end (one per lane or one for all)."""
        q, L = self.p, self.lanes
        y = np.array(y, float)
        t_end = np.broadcast_to(np.asarray(t_end, float), (L,))
        t = np.zeros(L)
        mode = np.full(L, NEAR if starts_touching else FREE)
        if starts_touching:
            self.begin_contact(np.ones(L, bool), -y[5])
        near_step = np.where(mode == NEAR, self._near_step(-y[5], contact_steps), flight_step)
        path = Path(L)
        for count in range(most + 1):
            near = mode == NEAR
            left = t_end - t
            alive = left > 1e-12
            h = np.where(alive, np.minimum(np.where(near, near_step, flight_step), np.maximum(left, 0)), 0.0)
            k1 = self.slope(t, y, near)
            path.add(t, y, k1, self.deepest, self.touched)
            if count == most or not alive.any():  # a lane that is not through by then has stuck to the wall
                path.failed = alive
                break
            k2 = self.slope(t + h / 2, y + h / 2 * k1, near)
            k3 = self.slope(t + h / 2, y + h / 2 * k2, near)
            k4 = self.slope(t + h, y + h * k3, near)
            new = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            part = np.ones(L)
            if self.wall:
                gap0, gap1 = y[2] - q["radius"] + y[U], new[2] - q["radius"] + new[U]
                comes = alive & ~near & (gap1 < self.reach) & (gap0 >= self.reach - 1e-13) & (new[5] < 0)
                outer = np.maximum(self.reach, np.where(self.touched, np.maximum(self.rupture, self.neck), 0))
                leaves = alive & near & (gap1 > outer) & (gap0 <= outer) & (new[5] > 0)
                event = comes | leaves
                if event.any():
                    level = np.where(comes, self.reach, outer)
                    part, new = self._locate(event, level, y, new, k1, k4, h)
                    # Forces may jump at the event: the step that leads to it ends with the slope from before.
                    path.end_with(np.where(event, self.slope(t + h * part, new, near), np.nan))
                touch = alive & ~self.touched & (comes & (self.reach == 0) | near & (gap1 < 0))
                if touch.any():
                    path.touch(touch, t + h * part, -new[5])
                    self.begin_contact(touch, -new[5])
                if event.any():
                    near_step = np.where(comes, self._near_step(np.maximum(-new[5], 1e-3), contact_steps), near_step)
                    mode = np.where(comes, NEAR, np.where(leaves, FREE, mode))
                    self.touched = self.touched & ~leaves
                    new[2] = np.where(leaves, q["radius"] + outer - new[U], new[2])  # where the rod's end has given way to
                    new[U] = np.where(leaves, 0.0, new[U])
                    new[S] = np.where(leaves, 0.0, new[S])
                self.deepest = np.where(self.touched, np.maximum(self.deepest, q["radius"] - new[2] - new[U]), 0.0)
                if self.shear != "none":
                    self._settle(new, (mode == NEAR) & self.touched & alive)
            y, t = new, t + h * part
        return path.close()

    def _near_step(self, speed, steps):
        h = laws.contact_time(self.law, self.p, speed) / steps
        thick = np.where(self.reach > 0, self.p["film_thickness"] / np.maximum(speed, 0.05) / 25, np.inf)
        stiff = 6 * np.pi * self.p["film_viscosity"] * self.p["radius"] ** 2 / self.p["film_cutoff"]
        return np.minimum(np.minimum(h, thick), np.where(stiff > 0, 0.8 * self.p["mass"] / np.maximum(stiff, 1e-30), np.inf))

    def _locate(self, event, level, y, new, k1, k4, h):
        """Part of the step at which the gap meets the level, and the state there."""
        q = self.p
        g0, g1 = y[2] - q["radius"] + y[U] - level, new[2] - q["radius"] + new[U] - level
        s0, s1 = h * (k1[2] + k1[U]), h * (k4[2] + k4[U])
        index = np.flatnonzero(event)
        g0, g1, s0, s1 = g0[index], g1[index], s0[index], s1[index]
        a, b = np.zeros(len(index)), np.ones(len(index))
        for _ in range(36):
            s = 0.5 * (a + b)
            same = (hermite(s, g0, g1, s0, s1) > 0) == (g1 > 0)
            b, a = np.where(same, s, b), np.where(same, a, s)
        part = np.ones_like(h)
        part[index] = 0.5 * (a + b)
        return part, np.where(event, hermite(part, y, new, h * k1, h * k4), new)

    def _settle(self, y, held):
        """Coulomb's limit after each step: a sliding spring keeps the stretch that carries the limit; rigid contacts stop sliding."""
        push, _ = self.normal(y, self.touched, self.deepest, self.beta)
        _, _, arm, more = self.tangential(y, push, self.beta)
        if self.shear == "spring":
            slides, limit, shear, trial, size = more
            kept = trial * limit / np.maximum(size * shear, 1e-30)
            y[S] = np.where(held & slides, kept, y[S])
        else:
            slip, before = more, getattr(self, "_slip", None)
            if before is not None:
                stops = held & self._held & ((slip * before).sum(0) <= 0)
                stuck = stops | (held & self._held & self._stuck)
                # The impulse that ends the sliding: mass over 1 + 5/2 (arm/radius)^2 at the point of contact.
                inverse = 1 / self.inertia + arm**2 / self.gyration
                impulse = np.where(stuck, -slip / inverse, 0.0)
                y[3:5] += impulse / self.inertia
                y[6] += arm * impulse[1] / self.gyration
                y[7] -= arm * impulse[0] / self.gyration
                slip = np.where(stuck, 0.0, slip)
                self._stuck = stuck
            else:
                self._stuck = np.zeros(self.lanes, bool)
            self._slip, self._held = slip.copy(), held.copy()


def hermite(s, y0, y1, d0, d1):
    """Cubic through two ends with slopes d (per whole step)."""
    return (1 + 2 * s) * (1 - s) ** 2 * y0 + s * (1 - s) ** 2 * d0 + s * s * (3 - 2 * s) * y1 + s * s * (s - 1) * d1


class Path:
    def __init__(self, lanes):
        self.t, self.y, self.d, self.deep, self.touch_flag, self.last = [], [], [], [], [], []
        self.touches = [[] for _ in range(lanes)]       # instants of first touch
        self.touch_speeds = [[] for _ in range(lanes)]

    def add(self, t, y, d, deep, touched):
        self.t.append(t.copy())
        self.y.append(y.copy())
        self.d.append(d.copy())
        self.deep.append(deep.copy())
        self.touch_flag.append(touched.copy())
        self.last.append(None)

    def end_with(self, slope):
        self.last[-1] = slope

    def touch(self, mask, t, speed):
        for lane in np.flatnonzero(mask):
            self.touches[lane].append(t[lane])
            self.touch_speeds[lane].append(speed[lane])

    def close(self):
        self.t, self.y, self.d = np.array(self.t), np.array(self.y), np.array(self.d)
        self.deep, self.touch_flag = np.array(self.deep), np.array(self.touch_flag)
        self.end = np.concatenate([self.d[1:], self.d[-1:]])  # slope at each step's end
        for k, slope in enumerate(self.last):
            if slope is not None:
                self.end[k] = np.where(np.isnan(slope), self.end[k], slope)
        return self

    def at(self, lane, times):
        """States (12, n) at the times, with the deepest overlap and the touching flag before each."""
        t = self.t[:, lane]
        times = np.clip(times, t[0], t[-1])
        i = np.clip(np.searchsorted(t, times, "right") - 1, 0, len(t) - 2)
        h = t[i + 1] - t[i]
        s = np.where(h > 0, (times - t[i]) / np.where(h > 0, h, 1), 0.0)
        y, d = self.y[:, :, lane], self.d[:, :, lane]
        out = hermite(s, y[i].T, y[i + 1].T, h * d[i].T, h * self.end[i, :, lane].T)
        return out, self.deep[i, lane], self.touch_flag[i, lane]
