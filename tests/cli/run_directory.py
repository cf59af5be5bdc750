"""A run's directory made by hand, so that drawing does not hang on tracking."""

import json
from pathlib import Path
from typing import Any

STATES = "time,track,status,x,y,vx,vy,p_x_x,p_x_y,p_y_y"


def write_run(path: Path, *, geodetic: bool = False, **changes: Any) -> Path:
    """Two tracks, one of which is confirmed late, over six scans of two sensors."""
    path.mkdir()
    rows = [STATES]
    for time in range(6):
        rows.append(f"{time},1,confirmed,{10 * time},0,10,0,9,0,9")
        status = "tentative" if time < 2 else "coasting"
        rows.append(f"{time},2,{status},{50 - 5 * time},40,-5,0,16,1,9")
    for name in ("tracks.csv", "history.csv"):
        (path / name).write_text("\n".join(rows) + "\n")
    reports = ["report,time,sensor,x,y"]
    assignments = ["report,time,sensor,track,probability"]
    for time in range(6):
        sensor = "ab"[time % 2]
        reports += [f"r{time},{time},{sensor},{10 * time},1", f"f{time},{time},{sensor},7,30"]
        assignments += [f"r{time},{time},{sensor},1,", f"f{time},{time},{sensor},,"]
    (path.parent / "reports.csv").write_text("\n".join(reports) + "\n")
    (path / "assignments.csv").write_text("\n".join(assignments) + "\n")
    record: dict[str, Any] = {
        "trackweave": "0.1.0",
        "command": "track",
        "configuration": {"sensors": {"a": {"position": [5.0, 5.0]}, "b": {"position": None}}},
        "input": {"dimensions": 2, "frame_origin": [51.5, -0.25] if geodetic else None},
        "scans": [
            {"time": time, "sensor": "ab"[time % 2], "reports": 2, "gap": gap}
            for time, gap in enumerate([0.0, 0.0, 0.01, 0.3, None, 0.0])
        ],
        "timing": {"scans": [{"cpu_ms": 1.5 + time} for time in range(6)]},
    }
    (path / "run.json").write_text(json.dumps(record | changes))
    return path
