"""What a recording adds to the truth: noise of several kinds, quantization, jitter of the clock, gaps, wild points."""
import numpy as np


class Noise:
    """One model for all channels; `sd` by channel. The whitening knows sd, correlation, quantization and jitter, not the wild points."""

    def __init__(self, rng, sd):
        self.sd = dict(sd)
        self.kind = rng.choice(["white", "correlated", "heavy_tailed"], p=[0.45, 0.3, 0.25])
        self.correlation = float(rng.uniform(0.4, 0.92)) if self.kind == "correlated" else 0.0
        self.quantum = {c: (float(s * rng.uniform(0.5, 2)) if rng.random() < 0.2 else 0.0) for c, s in sd.items()}
        self.jitter = 0.0                                   # set by the experiment [s]
        self.wild = float(rng.uniform(0.002, 0.01)) if rng.random() < 0.2 else 0.0

    def describe(self):
        return {"kind": self.kind, "sd": self.sd, "lag_1": self.correlation, "quantum": self.quantum, "clock_jitter": self.jitter,
                "wild_fraction": self.wild, "wild_points": "±(8 … 40) sd"}

    def spread(self, channel, slope):
        """Standard deviation of each sample, with quantization and the jitter's effect on a signal of this slope."""
        return np.sqrt(self.sd[channel] ** 2 + self.quantum[channel] ** 2 / 12 + (np.clip(np.abs(slope), 0, 1e300) * self.jitter) ** 2)

    def whiten(self, residual, channel, slope):
        """Rows of `residual` along the samples of one channel of one run."""
        r = residual / self.spread(channel, slope)
        rho = self.correlation
        if rho == 0:
            return r
        out = r.copy()
        out[..., 1:] = (r[..., 1:] - rho * r[..., :-1]) / np.sqrt(1 - rho**2)
        return out

    def draw(self, rng, n, channel):
        if self.kind == "heavy_tailed":
            e = rng.standard_t(3, n) / np.sqrt(3)
        else:
            e = rng.standard_normal(n)
            for i in range(1, n if self.correlation else 0):
                e[i] = self.correlation * e[i - 1] + np.sqrt(1 - self.correlation**2) * e[i]
        return self.sd[channel] * e

    def spoil(self, rng, values, channel):
        """Noise, wild points and quantization on one channel of one run."""
        out = values + self.draw(rng, len(values), channel)
        wild = rng.random(len(values)) < self.wild
        out = out + wild * rng.choice([-1, 1], len(values)) * rng.uniform(8, 40, len(values)) * self.sd[channel]
        q = self.quantum[channel]
        return np.round(out / q) * q if q > 0 else out
