"""
What was known then, and what is known now
==========================================

A display wants tracks as they were known at each moment: ``result.tracks``. Whoever looks back
has later reports too: ``result.history`` is amended and smoothed, and its errors are a fraction
as large, in turns above all.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw
from trackweave.simulation import Area, Manoeuvre, Scenario, SimulatedSensor, Target, simulate

turns = (Manoeuvre(30.0, 40.0, turn_rate_deg_s=4.0), Manoeuvre(85.0, 40.0, turn_rate_deg_s=-4.0))
scene = Scenario(
    area=Area((0.0, 0.0), (900.0, 700.0)),
    duration=149.0,
    sensors=(SimulatedSensor("radar", sigma=15.0, scan_period=2.0, detection_probability=0.95),),
    targets=(Target((80.0, 80.0), (8.0, 1.0), manoeuvres=turns),),
)
simulation = simulate(scene, rng=3)
result = tw.track(simulation.reports, {"motion": {"process_noise": 0.4, "max_speed": 20.0}})

truth = simulation.truth
figure, (plan, error) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
plan.plot(*simulation.reports.measurement.T, ".", color="0.7", label="reports")
plan.plot(*truth.position.T, "k--", lw=0.8, label="truth")
for name, table, colour in (
    ("known then", result.tracks, "tab:orange"),
    ("history", result.history, "tab:blue"),
):
    plan.plot(table["x"], table["y"], color=colour, label=name)
    time = table["time"].to_numpy()
    true = np.column_stack([np.interp(time, truth.time, axis) for axis in truth.position.T])
    off = np.linalg.norm(table.select("x", "y").to_numpy() - true, axis=1)
    error.plot(time, off, color=colour, label=f"{name}: {np.sqrt(np.mean(off**2)):.1f} m RMS")
plan.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
figure.legend(*plan.get_legend_handles_labels(), loc="outside lower center", ncols=4)
error.set(xlabel="time [s]", ylabel="error [m]", title="How far from the truth")
error.legend()
figure.savefig("smoothing.png")
