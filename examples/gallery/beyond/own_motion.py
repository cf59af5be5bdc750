"""
A motion model of your own
==========================

Boats that drift: speed fades within a minute, and waves stir it up again. One class with two
methods says so, and every part of the library uses it. Where boats are out of sight (grey), a
nearly constant velocity, the usual model, expects them (dotted) far beyond where they are.
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
        eye, way = np.eye(dim), np.sign(interval)[:, None, None]
        age = np.abs(interval)[:, None, None] / self.fading
        left, power = np.exp(-age), self.stirred**2
        slope = np.tile(np.eye(2 * dim), (len(mean), 1, 1))
        slope[:, :dim, dim:] = way * self.fading * (1 - left) * eye
        slope[:, dim:, dim:] = left * eye
        # Uhlenbeck and Ornstein (1930), of a place beside its speed: two steps are as one of both.
        noise = np.zeros_like(covariance)
        noise[:, :dim, :dim] = power * self.fading**2 * (2 * age - 3 + 4 * left - left**2) * eye
        noise[:, :dim, dim:] = way * power * self.fading * (1 - left) ** 2 * eye
        noise[:, dim:, :dim] = noise[:, :dim, dim:]
        noise[:, dim:, dim:] = power * (1 - left**2) * eye
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
        course += [(now, *row) for row in tracks.mean[:1]]
    course = np.array(course)
    unseen = np.diff(course[:, 0]).argmax() + 1
    (line,) = axes.plot(*course[:unseen, :2].T, "o-", ms=3, label=name)
    axes.plot(*course[unseen:, :2].T, "o-", ms=3, color=line.get_color())
    # What is expected of the last state before it: on a straight way, or ever more slowly.
    last, ahead = course[unseen - 1], np.linspace(0.0, 30.0, 60)
    if isinstance(motion, Drifting):
        way = motion.fading * (1.0 - np.exp(-ahead / motion.fading))
    else:
        way = ahead
    axes.plot(last[0] + ahead, last[1] + last[3] * way, ":", color=line.get_color())
axes.set(xlabel="time [s]", ylabel="x [m]")
axes.legend()
figure.savefig("own_motion.png")
