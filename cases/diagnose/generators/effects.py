"""The catalogue: what may be left out of a baseline, as numbers of the forward models and as keys of a case.

`strength` s >= 0 scales an effect; s = 0 is off. `values(s)` gives the forward model's numbers, `keys(s)` those of a case.
"""
import numpy as np

PAIR = "pair.ball.plate."


class Effect:
    def __init__(self, name, values, keys, start, cap, instrument=False, outside=False, hooks=None, note=""):
        self.name, self.values, self.keys, self.start, self.cap = name, values, keys, start, cap
        self.instrument, self.outside, self.hooks, self.note = instrument, outside, hooks, note


def single(name, number, key, start, cap, off=0.0, sign=1.0, extra=None, scale=1.0):
    """An effect of one number: off + sign * scale * s. `extra`: other keys that define it."""
    def of(s):
        return off + sign * scale * s
    extra_numbers, extra_keys = extra or ({}, {})
    return Effect(name, lambda s: {number: of(s), **(extra_numbers if s else {})}, lambda s: {key: of(s), **extra_keys}, start, cap)


def of_bodies(e):
    """Effects of the fluid on a ball of experiment e."""
    density = e.mass / (4 / 3 * np.pi * e.radius**3)
    viscous = float(np.min(e.mass / (6 * np.pi * e.radius)) / e.duration)
    out = [single("air_drag", "drag_coefficient", "medium.drag_coefficient", 0.1, 2.0),
           single("viscous_drag", "viscous_drag", "medium.viscous_drag", 0.02, 0.7, scale=viscous),
           single("buoyancy", "buoyancy", "medium.buoyancy", 0.02, 0.6, scale=float(density.min()))]
    if e.fluid_density > 100:
        out.append(single("added_mass", "added_mass", "medium.added_mass_coefficient", 0.05, 1.0))
    if e.spins:
        out.append(single("magnus", "magnus", "medium.magnus_coefficient", 0.1, 2.0))
    if e.schiller:
        out[0] = Effect("air_drag", lambda s: {"drag_coefficient": s, "schiller_naumann": 1.0 if s else 0.0},
                        lambda s: {"medium.drag_coefficient": s, "medium.drag": "schiller_naumann"}, 0.3, 3.0)
    return out


def of_contacts(e):
    """Effects at the contact of experiment e: deepest overlap, contact time, peak force of its baseline as scales."""
    d, T, F, R = e.deepest, e.contact_time, e.peak_force, float(e.radius.min())
    out = [single("velocity_dependent_restitution", "restitution_exponent", PAIR + "restitution_exponent", 0.1, 0.6,
                  extra=({"reference_speed": e.reference_speed}, {PAIR + "reference_speed": e.reference_speed})),
           single("velocity_dependent_restitution", "viscoelastic_time", PAIR + "viscoelastic_time", 0.02, 0.3, scale=T),
           single("nonlinear_stiffness", "hardening", PAIR + "hardening", 0.1, 2.0, scale=1 / d),
           single("nonlinear_stiffness", "stiffness_power", PAIR + "stiffness_power", 0.05, 0.5,
                  extra=({"reference_overlap": d}, {PAIR + "reference_overlap": d})),
           single("wave_loss", "wave_admittance", PAIR + "wave_admittance", 0.05, 0.5, scale=d / (T * F) * 3),
           single("powder_layer", "powder_layers", PAIR + "powder_layers", 0.1, 3.0),
           single("liquid_bridge", "bridge_volume", PAIR + "bridge_volume", 0.3, 20.0, scale=1e-3 * R**3,
                  extra=({"surface_tension": e.surface_tension}, {PAIR + "surface_tension": e.surface_tension}))]
    if e.law == "linear":
        out.append(single("plastic_contact", "unloading_ratio", PAIR + "unloading_ratio", 0.1, 2.0, off=1.0))
    if e.law == "hertz_mindlin":
        top = e.peak_pressure
        out.append(Effect("plastic_contact", lambda s: {"yield_pressure": top / (1 + s) if s else np.inf},
                          lambda s: {PAIR + "yield_pressure": top / (1 + s)}, 0.5, 2.0))
        out.append(single("adhesion", "surface_energy", PAIR + "surface_energy", 0.02, 0.25, scale=F / (1.5 * np.pi * R)))
    if e.kind != "contact":
        thick, cut = 0.03 * R, 0.002 * R
        out.append(single("lubrication", "film_viscosity", PAIR + "film_viscosity", 0.05, 1.0,
                          scale=float((e.mass / (6 * np.pi * e.radius**2)).min()) * e.reference_speed / np.log(thick / cut),
                          extra=({"film_thickness": thick, "film_cutoff": cut}, {PAIR + "film_thickness": thick, PAIR + "film_cutoff": cut})))
    if e.law == "power_law":
        out = [x for x in out if "restitution_exponent" not in str(x.keys(0.1))]
    return out


def of_instrument(e):
    """Effects of the instrument on a channel group of experiment e; numbers are named instrument:<what>:<group>."""
    out = []
    for group in e.groups:
        size = e.span(group)

        def add(name, what, off, start, cap, sign=1.0, scale=1.0):
            out.append(Effect(name, lambda s: {f"instrument:{what}:{group}": off + sign * scale * s} if s else {},
                              lambda s: {"instrument." + what: off + sign * scale * s, "instrument.channels": group}, start, cap, instrument=True))
        sign = 1.0 if e.coin else -1.0
        add("sensor_gain", "gain", 1.0, 0.01, 0.1, sign)
        if e.knows_zero(group):
            add("sensor_offset", "offset", 0.0, 0.01, 0.2, sign, size)
        if e.knows_time:
            add("clock_shift", "shift", 0.0, 0.01, 0.2, sign, e.time_scale)
        if group in ("force", "displacement"):
            add("sensor_lag", "lag", 0.0, 0.01, 0.2, 1.0, e.time_scale)
        add("saturation", "saturation", size, 0.05, 0.45, -1.0, size)
    return out


def sees(e, name):
    return name in [c for group in e.groups.values() for c in group]


def outside(e):
    """Functional forms that no effect of the catalogue has. `strange` is their strength as a force, torque or ratio."""
    out = []

    def add(name, start, cap, scale, note, **hooks):
        out.append(Effect(name, lambda s: {"strange": scale * s}, lambda s: {"strength": scale * s}, start, cap, outside=True, hooks=hooks, note=note))
    weight = 9.81 * float(np.mean(e.mass))
    T, speed = e.duration, e.reference_speed

    def along(axis, law):
        def field(t, y, q):
            f = np.zeros((3, y.shape[1]))
            f[axis] = q["strange"] * law(t, y, q)
            return f
        return field

    def against(law):
        def field(t, y, q):
            v = y[3:6]
            size = np.sqrt((v**2).sum(0))
            return -q["strange"] * law(size) * v / np.maximum(size, 1e-9)
        return field
    if e.kind in ("flight", "bounce", "impact_times"):
        add("thrust_dying_out", 0.05, 0.8, weight, "F_z = F exp(-t/tau)", field=along(2, lambda t, y, q: np.exp(-t / (0.15 * T))))
        add("periodic_force", 0.05, 0.5, weight, "F_z = F sin(2 pi f t)", field=along(2, lambda t, y, q: np.sin(2 * np.pi * 3.3 / T * t)))
    if e.kind == "flight":
        add("drag_crisis", 0.05, 0.8, weight, "F = -F (v/v1)^2 below a critical speed, a quarter of it above (smooth step)",
            field=against(lambda v: (v / speed) ** 2 * (1 - 0.375 * (1 + np.tanh((v - 0.55 * speed) / (0.04 * speed))))))
        add("force_in_band_of_height", 0.1, 1.0, weight, "F_z = F exp(-((z - z1)/w)^2)",
            field=along(2, lambda t, y, q: np.exp(-(((y[2] - e.middle) / (0.08 * e.height)) ** 2))))
        add("drag_v5", 0.05, 0.8, weight, "F = -F (v/v1)^5", field=against(lambda v: (v / speed) ** 5))
        if sees(e, "x"):
            add("side_gust", 0.05, 0.8, weight, "F_x = F in a band of height (Gaussian)",
                field=along(0, lambda t, y, q: np.exp(-(((y[2] - e.middle) / (0.1 * e.height)) ** 2))))
            add("spring_to_a_line", 0.05, 0.5, weight, "F_x = -F x/L", field=along(0, lambda t, y, q: -y[0] / e.height * 4))
    if e.kind in ("bounce", "impact_times"):
        add("magnet_below", 0.1, 0.8, weight, "F_z = -F exp(-(z - R)/l)", field=along(2, lambda t, y, q: -np.exp(-np.maximum(y[2] - q["radius"], 0) / (0.12 * e.height))))
        if e.law != "power_law":
            add("restitution_resonance", 0.02, 0.3, 1.0, "e(v) lower by a bump about one speed",
                restitution=lambda e0, v, q: e0 - q["strange"] / (1 + ((v - 0.75 * speed) / (0.07 * speed)) ** 2))
    if e.kind == "contact":
        F, d = e.peak_force, e.deepest
        add("force_bump_at_overlap", 0.02, 0.4, F, "F += F1 exp(-((d - d1)/w)^2)", elastic=lambda o, rate, q: q["strange"] * np.exp(-(((o - 0.45 * d) / (0.07 * d)) ** 2)))
        add("friction_in_guide", 0.02, 0.3, F, "F += F1 tanh(rate/v2): a force that opposes the motion, of constant size",
            elastic=lambda o, rate, q: q["strange"] * np.tanh(rate / (0.05 * speed)) * np.minimum(o / (0.03 * d), 1))
        out.append(Effect("stiffness_drift_over_runs", lambda s: {"drift": s}, lambda s: {"strength": s}, 0.02, 0.5, outside=True,
                          hooks={}, note="stiffness times 1 + s (i/n - 1/2) in run i: the specimen warms up"))
        add("ringing", 0.01, 0.3, F, "signal += A sin(2 pi f t) exp(-t/tau) from touch: a load cell that rings", signal=lambda t: np.where(
            t > 0, np.sin(2 * np.pi * 7.3 * t / e.contact_time) * np.exp(-np.maximum(t, 0) / (0.6 * e.contact_time)), 0))
    if e.kind == "roll":
        add("friction_falls_with_speed", 0.1, 0.9, 1.0, "mu (1 - s u/(u + u1))",
            friction=lambda u, q: q["friction"] * (1 - q["strange"] * u / (u + 0.4 * speed)))
        add("rough_patch", 0.02, 0.8, 0.2, "rolling resistance within a band of x only",
            rolling=lambda x, v, q: q["rolling_friction"] + q["strange"] * np.exp(-(((x - 0.4 * speed * T) / (0.06 * speed * T)) ** 2)))
        add("uneven_table", 0.005, 0.3, weight, "F_x = F sin(2 pi x/L)", field=lambda t, x, v, q: q["strange"] * np.sin(2 * np.pi * x / (0.31 * speed * T)))
        add("force_dying_out", 0.005, 0.3, weight, "F_x = F exp(-t/tau)", field=lambda t, x, v, q: q["strange"] * np.exp(-t / (0.12 * T)))
    if e.kind == "spin":
        torque = float((0.4 * e.mass * e.radius**2 / T).min())
        add("viscous_torque", 0.05, 2.0, torque, "M_z = -c w", drill=lambda w, q: -q["strange"] * w)
        add("quadratic_torque", 0.05, 2.0, torque / e.reference_spin, "M_z = -c |w| w", drill=lambda w, q: -q["strange"] * np.abs(w) * w)
    if e.kind == "oblique":
        add("friction_falls_with_speed", 0.1, 0.9, 1.0, "mu (1 - s u/(u + u1))",
            friction=lambda u, q: q["friction"] * (1 - q["strange"] * u / (u + 0.3 * speed)))
        add("restitution_resonance", 0.02, 0.3, 1.0, "e(v) lower by a bump about one speed",
            restitution=lambda e0, v, q: e0 - q["strange"] / (1 + ((v - 0.7 * speed) / (0.07 * speed)) ** 2))
    return out


def on_plane(e):
    out = [x for x in of_bodies(e) if x.name in ("air_drag", "viscous_drag", "added_mass")]
    if e.kind == "spin":
        return [] if "torsional_friction" in e.base else [single("torsional_friction", "torsional_friction", PAIR + "torsional_friction", 1e-3, 0.1)]
    if "rolling_friction" not in e.base:
        out.append(single("rolling_resistance", "rolling_friction", PAIR + "rolling_friction", 1e-3, 0.05))
    if e.base["friction"] == 0:
        out.append(single("sliding_friction", "friction", PAIR + "friction", 0.01, 0.5))
    return out


def at_oblique_impact(e):
    keep = ("velocity_dependent_restitution",)
    out = [x for x in of_contacts(e) if x.name in keep]
    if e.base["friction"] == 0:
        out.append(single("sliding_friction", "friction", PAIR + "friction", 0.01, 0.6))
    else:
        out.append(single("tangential_compliance", "tangential_compliance", PAIR + "tangential_compliance", 0.5, 5.0))
    return out
