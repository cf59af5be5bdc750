"""
Objects that turn: interacting models
=====================================

A filter for straight courses needs a large process noise not to lose who turns, and is restless
on the straights. Two models that take turns, straight on and turning, have both: the probability
of each follows from the reports.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw
from trackweave.simulation import Area, Manoeuvre, Scenario, SimulatedSensor, Target, simulate

turns = (Manoeuvre(40.0, 20.0, turn_rate_deg_s=9.0), Manoeuvre(100.0, 30.0, turn_rate_deg_s=-6.0))
scene = Scenario(
    area=Area((-2000.0, -2000.0), (6000.0, 6000.0)),
    duration=179.0,
    sensors=(SimulatedSensor("radar", sigma=25.0, scan_period=1.0, detection_probability=0.95),),
    targets=(Target((0.0, 0.0), (60.0, 0.0), manoeuvres=turns),),
)
simulation, sensor = (
    simulate(scene, rng=1),
    {"sigma": 25.0, "clutter_density": 1e-9, "scan_period": 1.0},
)
straight = {"model": "constant-velocity", "process_noise": 0.1}
turning = {"model": "coordinated-turn", "process_noise": 0.1, "turn_noise": 1e-3}
ways = {"models": ["straight", "turning"], "straight": straight, "turning": turning}
models = {
    "straight, restless": {
        "model": "constant-velocity",
        "process_noise": 40.0,
        "max_speed": 100.0,
    },
    "both, interacting": {"model": "imm", "max_speed": 100.0, "imm": ways},
}
truth = simulation.truth
figure, (plan, error) = plt.subplots(1, 2, figsize=(10, 4.4))
plan.plot(*truth.position.T, "k--", lw=0.8, label="truth")
for name, motion in models.items():
    result = tw.track(simulation.reports, {"motion": motion, "sensors": {"radar": sensor}})
    path = result.tracks.select("time", "x", "y").to_numpy()
    true = np.column_stack([np.interp(path[:, 0], truth.time, axis) for axis in truth.position.T])
    off = np.linalg.norm(path[:, 1:] - true, axis=1)
    plan.plot(path[:, 1], path[:, 2], label=name)
    lately = np.sqrt(np.convolve(off**2, np.ones(15) / 15, "valid"))
    error.plot(path[7:-7, 0], lately, label=f"{name}: {np.sqrt(np.mean(off**2)):.1f} m in all")
plan.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
for turn in turns:
    error.axvspan(turn.start, turn.end, color="0.92")
error.set(xlabel="time [s], turns are grey", ylabel="RMS error over 15 s [m]", ylim=(0, 50))
error.legend(loc="upper right")
plan.legend(loc="lower center", bbox_to_anchor=(0.5, 1.02))
figure.savefig("turning.png")
