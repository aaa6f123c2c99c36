"""Writes the baseline of a trial as a quern case: one ball, a plane where there is one, and the [diagnose] table."""
import numpy as np


def toml(x):
    if isinstance(x, str):
        return f'"{x}"'
    if isinstance(x, (list, tuple, np.ndarray)):
        return "[" + ", ".join(toml(v) for v in x) + "]"
    return f"{float(x):.8g}"


def write_case(e, path, name, rng):
    value = {key: e.base.get(number, 0.0) for key, number, _ in e.free}
    value.update(e.case_values)

    def of(key, default):
        return value.get(key, default)
    m, R = float(e.mass[0]), float(e.radius[0])
    start = first_state(e)
    walls = e.kind != "flight"
    T = e.duration * 1.02
    lines = [f'name = "{name}"', f'title = "{TITLES[e.kind]}"', f"duration = {toml(T)}", "gravity = [0, 0, -9.81]", ""]
    if walls:
        lines += ["[time_step]", f"value = {toml(step(e))}", ""]
    else:
        lines += ["[time_step]", f"value = {toml(flight_step(e))}", ""]
    density = m / (4 / 3 * np.pi * R**3)
    lines += ["[material.ball]", f"density = {toml(density)}"]
    hertz = e.law == "hertz_mindlin" and e.kind not in ("flight", "roll", "spin")
    if hertz:
        lines += [f"young = {toml(of('material.ball.young', e.base['effective_young']) * (1 - e.poisson**2))}", f"poisson = {toml(e.poisson)}"]
    if walls:
        lines += ["", "[material.plate]", "density = 8000"]
        if hertz:
            lines += ["young = 1e14  # rigid beside the ball", f"poisson = {toml(e.poisson)}"]
        lines += ["", "[pair.ball.plate]"]
        if e.kind in ("roll", "spin"):
            lines += ['law = "linear"', f"normal_stiffness = {toml(e.stiffness)}", "restitution = 0.5",
                      f"friction = {toml(of('pair.ball.plate.friction', e.base['friction']))}"]
            if "rolling_friction" in e.base:
                lines += [f"rolling_friction = {toml(of('pair.ball.plate.rolling_friction', e.base['rolling_friction']))}"]
            if "torsional_friction" in e.base:
                lines += [f"torsional_friction = {toml(of('pair.ball.plate.torsional_friction', e.base['torsional_friction']))}"]
        elif e.law == "power_law":
            lines += ['law = "power_law"', f"stiffness_coefficient = {toml(of('pair.ball.plate.stiffness_coefficient', e.base['stiffness_coefficient']))}",
                      f"stiffness_exponent = {toml(e.base['stiffness_exponent'])}",
                      f"damping_coefficient = {toml(of('pair.ball.plate.damping_coefficient', e.base['damping_coefficient']))}",
                      f"damping_exponent = {toml(e.base['damping_exponent'])}", f"impact_mass = {toml(m)}", f"impact_speed = {toml(e.reference_speed)}"]
        else:
            lines += [f'law = "{e.law}"']
            if e.law == "linear":
                lines += [f"normal_stiffness = {toml(of('pair.ball.plate.normal_stiffness', e.base['normal_stiffness']))}"]
            lines += [f"restitution = {toml(of('pair.ball.plate.restitution', e.base['restitution']))}"]
            if "friction" in e.base:
                lines += [f"friction = {toml(of('pair.ball.plate.friction', e.base['friction']))}"]
            if "tangential_compliance" in e.base:
                lines += [f"tangential_compliance = {toml(e.base['tangential_compliance'])}"]
        lines += ["", "[wall.plate]", 'type = "plane"', 'material = "plate"']
    soft = 0.1 * stiffness(e) if walls else 0.5 * e.mass.min() * (np.pi / (40 * flight_step(e))) ** 2
    lines += ["", "[pair.ball.ball]  # there is but one ball", 'law = "linear"', f"normal_stiffness = {soft:.3g}", "restitution = 1"]
    lines += ["", "[species.ball]", 'material = "ball"', f"diameter = {toml(2 * R)}", "", "[insert.ball]", 'species = "ball"', 'method = "list"',
              f"positions = [{toml(start[0:3])}]", f"velocity = {toml(start[3:6])}", f"spin = {toml(start[6:9])}"]
    if e.kind in ("roll", "spin"):
        lines += ["allowed_overlap = 1e-3"]
    if e.fluid_density != 1.2 or "drag_coefficient" in e.base:
        lines += ["", "[medium]", f"density = {toml(e.fluid_density)}", f"viscosity = {toml(e.base.get('fluid_viscosity', 1.8e-5))}"]
        if "drag_coefficient" in e.base:
            lines += [f"drag_coefficient = {toml(of('medium.drag_coefficient', e.base['drag_coefficient']))}"]
    lines += ["", "[output]", "paraview = false", "pictures = false", "", "[observe]", "power = false", "shell_force = false", "spectrum = false", "charge = false"]
    lines += ["", "[diagnose]", "free = [" + ", ".join(f'"{k}"' for k, _, _ in e.free) + "]"]
    bounds = {k: b for k, _, b in e.free if b}
    if bounds and rng.random() < 0.6:
        lines.append("bounds = {" + ", ".join(f'"{k}" = {toml(b)}' for k, b in bounds.items()) + "}")
    lines.append(f'initial_state = "{e.initial_state}"')
    path.write_text("\n".join(lines) + "\n")


TITLES = {"flight": "A ball in flight", "bounce": "A ball bouncing on a plate", "impact_times": "A bouncing ball, heard",
          "contact": "Impact on a plate: force and displacement", "oblique": "Oblique impact: rebound velocity and spin",
          "roll": "A ball sliding and rolling on a plane", "spin": "A ball spinning on a plane"}


def flight_step(e):
    return min(1e-3, e.duration / 500)


def step(e):
    """Time step: a fraction of the shortest contact."""
    if e.kind in ("roll", "spin"):
        return float(f"{np.pi * np.sqrt(e.mass.min() / e.stiffness) / 50:.2g}")
    shortest = float(np.min(e.times_of_contact))
    return float(f"{shortest / {'contact': 1000, 'oblique': 500}.get(e.kind, 600 if e.law == 'linear' else 250):.2g}")


def stiffness(e):
    return e.stiffness if e.kind in ("roll", "spin") else e.peak_force / e.deepest


def first_state(e):
    if e.kind in ("roll", "spin"):
        y = np.zeros(9)
        y[2], y[3], y[7] = e.conditions["z0 [m]"][0], e.v0[0], e.w0[0]
        y[8] = getattr(e, "w", [0.0])[0]
        return np.round(y, 9)
    y = e.start()[:9, 0].copy()
    if e.kind in ("contact", "oblique"):
        y[2] += 1e-9 * y[2]
    return y
