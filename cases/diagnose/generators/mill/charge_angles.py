"""Toe and shoulder as docs/angles.md defines them, from places of balls and the forces on them.

Counted from 12 o'clock in the sense in which the mill turns. The layer next to the shell: centres within a ball and the height of the bars from
it, without balls in free flight (contacts press with less than a tenth of the weight). Each ball is spread over the sectors as seven points; the
profile is smoothed over three sectors; its ends are where it falls below half of its self-weighted mean, walking from the middle.
"""
import numpy as np

SECTORS = 120


def layer(x, y, fx, fy, fz, mass, layer_from, ball_radius, gravity=9.81):
    """Occupancy of the sectors, from arrays of all balls. The mill turns anticlockwise about z, gravity pulls to −y."""
    pressed = np.hypot(np.hypot(fx, fy + mass * gravity), fz) / mass >= 0.1 * gravity
    held = pressed & (np.hypot(x, y) > layer_from)
    counts = np.zeros(SECTORS)
    reach = np.sqrt(4 / 7) * ball_radius
    spokes = [(0.0, 0.0, 0.3)] + [(reach * np.cos(k * np.pi / 3), reach * np.sin(k * np.pi / 3), 0.7 / 6) for k in range(6)]
    for dx, dy, weight in spokes:
        angle = np.degrees(np.arctan2(-(x[held] + dx), y[held] + dy)) % 360
        counts += weight * np.bincount((angle / 360 * SECTORS).astype(int) % SECTORS, minlength=SECTORS)
    return counts


def ends(profile):
    """Toe and shoulder [degrees]; nan where the profile has no two ends."""
    p = (np.roll(profile, 1) + profile + np.roll(profile, -1)) / 3
    width, half = 360 / SECTORS, 0.5 * np.sum(p**2) / np.sum(p)
    sector = np.radians((np.arange(SECTORS) + 0.5) * width)
    start = int(np.degrees(np.arctan2(np.sum(p**2 * np.sin(sector)), np.sum(p**2 * np.cos(sector)))) % 360 / width) % SECTORS
    found = []
    for step in (-1, 1):
        k, walked = start, 0
        while walked < SECTORS and p[(k + step) % SECTORS] >= half:
            k, walked = (k + step) % SECTORS, walked + 1
        if p[start] < half or walked >= SECTORS:
            return np.nan, np.nan
        found.append(((k + 0.5) * width + step * width * (p[k] - half) / (p[k] - p[(k + step) % SECTORS])) % 360)
    return tuple(found)
