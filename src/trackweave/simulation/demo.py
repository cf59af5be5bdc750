"""The scene of ``trackweave demo``: three radars at a harbour's mouth."""

from trackweave.simulation.scenario import Area, Scenario, SimulatedSensor
from trackweave.simulation.targets import Crossing, Manoeuvre, Parallel, Target

__all__ = ["demo_configuration", "demo_scenario"]


def demo_scenario() -> Scenario:
    """Return three radars that take turns, and nine boats: three cross, two go side by side.

    Returns
    -------
    The scenario.

    Examples
    --------
    >>> from trackweave.simulation import demo_scenario
    >>> scene = demo_scenario()
    >>> [sensor.name for sensor in scene.sensors], len(scene.explicit_targets())
    (['lighthouse', 'pier', 'headland'], 9)
    """
    # Sixty scans, one every two seconds. Each radar turns once in six seconds, misses one boat in
    # seven and adds some eight false alarms a turn.
    radars = tuple(
        SimulatedSensor(
            name=name,
            sigma=8.0,
            detection_probability=0.86,
            clutter_per_scan=8.0,
            scan_period=6.0,
            start_offset=2.0 * turn,
            position=position,
        )
        for turn, (name, position) in enumerate(
            [
                ("lighthouse", (60.0, 60.0)),
                ("pier", (1940.0, 60.0)),
                ("headland", (1000.0, 1340.0)),
            ]
        )
    )
    return Scenario(
        area=Area((0.0, 0.0), (2000.0, 1400.0)),
        duration=119.0,
        sensors=radars,
        crossings=(Crossing((1000.0, 700.0), time=60.0, speed=11.0, count=3, angle_deg=35.0),),
        parallels=(Parallel((1750.0, 1180.0), (-9.0, 0.5), spacing=70.0),),
        targets=(
            Target(
                (250.0, 120.0),
                (12.0, 1.0),
                manoeuvres=(Manoeuvre(start=40.0, duration=24.0, turn_rate_deg_s=3.6),),
            ),
            Target(
                (1780.0, 180.0),
                (-1.5, 10.0),
                manoeuvres=(Manoeuvre(start=50.0, duration=30.0, turn_rate_deg_s=2.6),),
            ),
            Target((140.0, 1220.0), (6.0, -6.5), end=96.0),
            Target((620.0, 80.0), (-4.0, 9.0), start=30.0),
        ),
        process_noise=0.02,
    )


def demo_configuration(scenario: Scenario, seed: int) -> str:
    """Return the configuration file of the demo: what is known of boats and radars.

    Parameters
    ----------
    scenario
        The demo's, or another with the sensors that are to be told.
    seed
        The seed of the run.

    Returns
    -------
    The file's text.

    Examples
    --------
    >>> import tomllib
    >>> from trackweave.simulation import demo_configuration, demo_scenario
    >>> tomllib.loads(demo_configuration(demo_scenario(), seed=1))["motion"]
    {'process_noise': 0.5, 'max_speed': 20.0}
    """
    lines = [
        "# What one would know beforehand; everything else is estimated from the reports.",
        f"seed = {seed}",
        "",
        "[motion]  # boats: up to 40 knots, and some of them turn",
        "process_noise = 0.5",
        "max_speed = 20.0",
    ]
    for sensor in scenario.sensors:
        lines += [
            "",
            f"[sensors.{sensor.name}]",
            f"sigma = {sensor.sigmas(scenario.area.dim)[0]}",
            f"detection_probability = {sensor.detection_probability}",
            f"clutter_per_scan = {sensor.clutter_per_scan}",
            f"scan_period = {sensor.scan_period}",
        ]
        if sensor.position is not None:
            lines.append(f"position = [{sensor.position[0]}, {sensor.position[1]}]")
    return "\n".join(lines) + "\n"
