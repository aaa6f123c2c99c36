"""Restitution and damping of Hertz's contact whose force never pulls, by integrating a head-on collision."""
import numpy as np


def rebound(force, speed, mass=1.0, scale=1.0):
    """Speed of parting over `speed`. force(overlap, closing speed), clipped at 0; scale: of the overlap."""
    dt = 2e-4 * scale / speed
    state = np.array([0.0, speed])

    def rate(s):
        return np.array([s[1], -max(0.0, force(s[0], s[1])) / mass if s[0] > 0 else 0.0])

    while True:
        a = rate(state)
        b = rate(state + 0.5 * dt * a)
        c = rate(state + 0.5 * dt * b)
        state = state + dt / 6 * (a + 2 * b + 2 * c + rate(state + dt * c))
        if state[1] < 0 and rate(state)[1] == 0:
            return -state[1] / speed


def solve(function, wanted, low, high):
    """Where a falling function has a value."""
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > wanted else (low, middle)
    return 0.5 * (low + high)


def tsuji_ratio(restitution):
    """β of the dashpot 2 √(5/6) β √(S_n m*) that gives this restitution, at any speed: in units in which F = δ^(3/2), m* = 1."""
    def measured(beta):
        return rebound(lambda d, v: d**1.5 + 2 * np.sqrt(5 / 6) * beta * np.sqrt(1.5 * np.sqrt(max(d, 0))) * v, 1.0)
    return solve(measured, restitution, 0.0, 3.0)


def liggghts_restitution(restitution):
    """What LIGGGHTS must be told: it takes β = −ln e / √(ln² e + π²), of the linear law."""
    beta = tsuji_ratio(restitution)
    return np.exp(-np.pi * beta / np.sqrt(1 - beta**2))


def root_damping(restitution, speed, young, radius, mass):
    """γ of the dashpot γ m* √(R* δ) v with this restitution at one speed. young: E*, radius: R*, mass: m*."""
    scale = (mass * speed**2 / (young * np.sqrt(radius))) ** 0.4

    def measured(gamma):
        return rebound(lambda d, v: (4 / 3 * young * d + gamma * mass * v) * np.sqrt(radius * max(d, 0)), speed, mass, scale)
    return solve(measured, restitution, 0.0, 10 * young * scale / (mass * speed))
