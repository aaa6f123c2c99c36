"""Restitution and damping of Hertz's contact whose force never pulls, by integrating a head-on collision."""
from math import exp, pi, sqrt


def rebound(force, speed, mass=1.0, scale=1.0):
    """Speed of parting over `speed`. force(overlap, closing speed), clipped at 0; scale: of the overlap."""
    dt = 1e-3 * scale / speed
    d, v = 0.0, speed

    def slowing(d, v):
        return max(0.0, force(d, v)) / mass if d > 0 else 0.0

    while True:
        a1 = slowing(d, v)
        v2 = v - 0.5 * dt * a1
        a2 = slowing(d + 0.5 * dt * v, v2)
        v3 = v - 0.5 * dt * a2
        a3 = slowing(d + 0.5 * dt * v2, v3)
        v4 = v - dt * a3
        d, v = d + dt / 6 * (v + 2 * v2 + 2 * v3 + v4), v - dt / 6 * (a1 + 2 * a2 + 2 * a3 + slowing(d + dt * v3, v4))
        if v < 0 and slowing(d, v) == 0:
            return -v / speed


def solve(function, wanted, low, high):
    """Where a falling function has a value."""
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > wanted else (low, middle)
    return 0.5 * (low + high)


def tsuji_ratio(restitution):
    """β of the dashpot 2 √(5/6) β √(S_n m*) that gives this restitution, at any speed: in units in which F = δ^(3/2), m* = 1."""
    def measured(beta):
        return rebound(lambda d, v: d**1.5 + 2 * sqrt(5 / 6) * beta * sqrt(1.5 * sqrt(max(d, 0))) * v, 1.0)
    return solve(measured, restitution, 0.0, 3.0)


def liggghts_restitution(restitution):
    """What LIGGGHTS must be told: it takes β = −ln e / √(ln² e + π²), of the linear law."""
    beta = tsuji_ratio(restitution)
    return exp(-pi * beta / sqrt(1 - beta**2))


def root_damping(restitution, speed, young, radius, mass):
    """γ of the dashpot γ m* √(R* δ) v with this restitution at one speed. young: E*, radius: R*, mass: m*."""
    scale = (mass * speed**2 / (young * sqrt(radius))) ** 0.4

    def measured(gamma):
        return rebound(lambda d, v: (4 / 3 * young * d + gamma * mass * v) * sqrt(radius * max(d, 0)), speed, mass, scale)
    return solve(measured, restitution, 0.0, 10 * young * scale / (mass * speed))
