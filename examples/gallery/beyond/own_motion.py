"""
A motion model of your own
==========================

Boats that drift: speed fades within a minute, and waves stir it up again. One class with two
methods says so, and every part of the library uses it. Where boats are out of sight (grey), a
nearly constant velocity, the usual model, expects them farther on than the drifting one.
"""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw


@dataclass(frozen=True, slots=True)
class Drifting:
    """Boats that drift."""

    fading: float = 20.0  # s until a speed has fallen to 1/e
    stirred: float = 0.6  # m/s along each axis, in the long run
    max_speed: float = 10.0

    def begin(self, position, covariance):
        rows, dim = position.shape
        mean, spread = np.zeros((rows, 2 * dim)), np.zeros((rows, 2 * dim, 2 * dim))
        mean[:, :dim], spread[:, :dim, :dim] = position, covariance
        spread[:, dim:, dim:] = 5.0**2 * np.eye(dim)
        return mean, spread

    def predict(self, mean, covariance, interval):
        dim = mean.shape[1] // 2
        left = np.exp(-np.abs(interval) / self.fading)[:, None, None] * np.eye(dim)
        slope = np.tile(np.eye(2 * dim), (len(mean), 1, 1))
        slope[:, :dim, dim:] = (
            np.sign(interval)[:, None, None] * self.fading * (np.eye(dim) - left)
        )
        slope[:, dim:, dim:] = left
        noise = np.zeros_like(covariance)
        noise[:, dim:, dim:] = self.stirred**2 * (np.eye(dim) - left**2)
        noise[:, :dim, :dim] = noise[:, dim:, dim:] * interval[:, None, None] ** 2
        return (
            np.einsum("rij,rj->ri", slope, mean),
            slope @ covariance @ slope.swapaxes(1, 2) + noise,
            slope,
        )


time = np.arange(0.0, 90.0, 2.0)
true = 200.0 * (1.0 - np.exp(-time / 25.0))
hidden, rng = (time > 30.0) & (time < 62.0), np.random.default_rng(2)
radar = tw.Sensor(
    "radar", sigma=3.0, clutter_density=1e-8, scan_period=2.0, detection_probability=0.9
)
figure, axes = plt.subplots()
axes.axvspan(31.0, 61.0, color="0.93")
axes.plot(time, true, "k--", lw=1, label="truth")
for name, motion in {
    "drifting": Drifting(),
    "constant velocity": tw.ConstantVelocity(0.05, 10.0),
}.items():
    tracker, course = tw.MultiHypothesisTracker(motion=motion, sensors=[radar]), []
    for k, now in enumerate(time):
        seen = [] if hidden[k] else [[true[k] + rng.normal(0, 3.0), rng.normal(0, 3.0)]]
        tracks = tracker.step(tw.Scan(time=now, sensor="radar", measurement=seen)).tracks
        course += [(now, *row[:1]) for row in tracks.mean[:1]]
    axes.plot(*np.transpose(course), "o-", ms=3, label=name)
axes.set(xlabel="time [s]", ylabel="x [m]")
axes.legend()
figure.savefig("own_motion.png")
