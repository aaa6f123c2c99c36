"""Contact laws and what damps them, from their equations.

Lanes: every quantity is an array with one entry per ball that is followed. F > 0 pushes the ball off the wall.
"""
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

SQRT56 = np.sqrt(5.0 / 6.0)


def linear_restitution(beta):
    """e of a linear spring and dashpot whose force is never attractive; Schwager & Poeschel (2007)."""
    beta = np.asarray(beta, float)
    omega = np.sqrt(1 - beta**2)
    return np.exp(-beta / omega * (np.pi - np.arctan2(2 * beta * omega, 1 - 2 * beta**2)))


def hertz_restitution(beta):
    """e of Hertz's spring with Tsuji's dashpot, in units where m = 1 and F = x^1.5 (it does not depend on the speed)."""
    def push(x, v):
        x = max(x, 0.0)
        return x**1.5 + 2 * SQRT56 * beta * np.sqrt(1.5 * np.sqrt(x)) * v

    def attracts(t, y):
        return push(*y) if t > 0.1 else 1.0
    attracts.terminal = True
    end = solve_ivp(lambda t, y: (y[1], -push(*y)), (0, 30), (0, 1), method="DOP853", events=attracts, rtol=1e-10, atol=1e-13)
    return -end.y[1, -1]


_BETA = np.concatenate([np.linspace(0, 0.2, 41), np.linspace(0.21, 0.95, 75)])
_TABLE = {}


def damping_ratio(law, restitution):
    """beta for which the law measures this restitution (0.14 … 1)."""
    if law not in _TABLE:
        e = linear_restitution(_BETA) if law == "linear" else np.array([hertz_restitution(b) for b in _BETA])
        _TABLE[law] = CubicSpline(-np.log(e), _BETA)
    loss = -np.log(np.clip(restitution, 0.14, 1.0))
    return _TABLE[law](loss)


def contact_time(law, p, speed):
    """Duration of the undamped contact, for the choice of steps [s]."""
    if law == "linear":
        return np.pi * np.sqrt(p["mass"] / p["normal_stiffness"])
    if law == "power_law":
        k, r = p["stiffness_coefficient"], p["stiffness_exponent"]
        deepest = ((r + 1) * p["mass"] * speed**2 / (2 * k)) ** (1 / (r + 1))
    else:
        deepest = (15 * p["mass"] * speed**2 / (16 * p["effective_young"] * np.sqrt(p["radius"]))) ** 0.4
    return 2.94 * deepest / np.maximum(speed, 1e-6)


def spring(law, p, overlap):
    """Elastic force and its slope dF/d(overlap), as the baseline law has them."""
    d = np.maximum(overlap, 0)
    if law == "linear":
        return p["normal_stiffness"] * d, p["normal_stiffness"] + 0 * d
    if law == "power_law":
        k, r = p["stiffness_coefficient"], p["stiffness_exponent"]
        return k * d**r, k * r * d ** (r - 1)
    slope = 2 * p["effective_young"] * np.sqrt(p["radius"] * d)
    return 2 / 3 * slope * d, slope


def dashpot(law, p, overlap, slope, beta):
    """Damping c in F = c * (rate of overlap)."""
    if law == "power_law":
        return p["damping_coefficient"] * np.maximum(overlap, 0) ** p["damping_exponent"]
    factor = 1.0 if law == "linear" else SQRT56
    return 2 * factor * beta * np.sqrt(slope * p["mass"])


def yielding(p, overlap, deepest):
    """Thornton (1997): Hertz to the yield overlap, a straight line beyond, Hertz of a flattened contact on the way back."""
    E, R, py = p["effective_young"], p["radius"], np.minimum(p["yield_pressure"], 1e30)
    d_y = R * (np.pi * py / (2 * E)) ** 2
    F_y = 4 / 3 * E * np.sqrt(R) * np.minimum(d_y, 1e3) ** 1.5
    d, top = np.maximum(overlap, 0), np.maximum(deepest, overlap)
    hertz = 4 / 3 * E * np.sqrt(R) * d**1.5
    line = F_y + np.pi * py * R * (d - d_y)
    F_top = F_y + np.pi * py * R * (top - d_y)
    yielded = top > d_y
    with np.errstate(all="ignore"):
        R_p = R * F_y_ratio(E, R, F_top, F_y, py)
        d_p = top - (3 * F_top / (4 * E * np.sqrt(R_p))) ** (2 / 3)
        back = 4 / 3 * E * np.sqrt(R_p) * np.maximum(d - d_p, 0) ** 1.5
    return np.where(yielded, np.where(overlap >= top, line, back), hertz)


def F_y_ratio(E, R, F_top, F_y, py):
    """R_p/R of the flattened contact: 4E/(3F) ((2F + F_y)/(2 pi p_y))^{3/2} over R."""
    return 4 * E / (3 * F_top * R) * ((2 * F_top + F_y) / (2 * np.pi * py)) ** 1.5


def neck_breaks_at(p):
    """JKR under controlled displacement: the (negative) overlap at which the neck breaks."""
    pull = np.sqrt(2 * np.pi * p["surface_energy"] / p["effective_young"])
    a = (p["radius"] / 4 * pull) ** (2 / 3)
    return a**2 / p["radius"] - pull * np.sqrt(a)


def jkr(p, overlap):
    """JKR force and contact radius on the branch that is stable under controlled displacement."""
    E, R, w = p["effective_young"], p["radius"], p["surface_energy"]
    pull = np.sqrt(2 * np.pi * w / E)
    d = np.maximum(overlap, neck_breaks_at(p))
    a = np.sqrt(R * np.maximum(d, 0)) + (R * pull) ** (2 / 3) + 1e-12
    least = (R / 4 * pull) ** (2 / 3) + 1e-12
    for _ in range(12):
        step = (a**2 / R - pull * np.sqrt(a) - d) / np.maximum(2 * a / R - 0.5 * pull / np.sqrt(a), 1e-30)
        a = np.maximum(a - step, least)
    return 4 * E * a**3 / (3 * R) - np.sqrt(8 * np.pi * w * E) * a**1.5, a


def bridge_rupture(p):
    """Willett et al. (2000), sphere on plane: rupture distance from volume and wetting angle."""
    R = 2 * p["radius"]
    v = p["bridge_volume"] / R**3
    return (1 + p["wetting_angle"] / 2) * (np.cbrt(v) + 0.1 * np.cbrt(v) ** 2) * R


def bridge_pull(p, gap):
    """Willett et al. (2000), their short form: 2 pi R gamma cos(theta)/(1 + 1.05 s + 2.5 s^2), s = gap sqrt(R/V), R = 2 R*."""
    R, volume = 2 * p["radius"], np.maximum(p["bridge_volume"], 1e-30)
    s = np.maximum(gap, 0) * np.sqrt(R / volume)
    pull = 2 * np.pi * R * p["surface_tension"] * np.cos(p["wetting_angle"]) / (1 + 1.05 * s + 2.5 * s**2)
    return np.where(p["bridge_volume"] > 0, pull, 0.0)
