"""A cluster of Ray of four machines on this one: the bytes of one machine, also with one killed.

Run ``python benchmarks/cluster.py`` on Linux. Each machine is a network namespace of its own
with an address on a bridge, all within a namespace that reaches nothing else (``unshare`` with
user namespaces, and ``ip``): a head that does no work, and three with one processor each. They
ask for a token made for this run. On the head, ``trackweave track``, a study, and a search on
islands are run with ``--engine ray://HEAD`` and with ``local``; then ``track`` again, while a
machine is killed with all its processes. Last, a machine joins that claims another version of
trackweave.

Prints what each gave, and ends with status 1 if bytes differ or a refusal does not come.
"""

import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

N_MACHINES, NET, BRIDGE = 4, "10.77.0", "machines"
HEAD = f"{NET}.1"
ENGINE = f"ray://{HEAD}"
STUDIED = ("runs.parquet", "summary.csv")
BARE = ("tracks.csv", "assignments.csv", "history.csv")
TRACKER = """
[motion]
process_noise = 1.0
max_speed = 300.0
[sensors.default]
sigma = 20.0
detection_probability = 0.95
scan_period = 1.0
clutter_density = 1e-9
[lifecycle]
new_target_density = 1e-9
"""
STUDY = """
[study]
seeds = 4
[scenarios.sea]
file = "scene.toml"
[configurations.window]
[configurations.nearest.set]
tracker.kind = "nearest-neighbour"
"""
SCENE = """
duration = 60.0
process_noise = 0.1
[area]
low = [0, 0]
high = [2000, 2000]
[[sensors]]
name = "radar"
sigma = 10.0
scan_period = 2.0
clutter_per_scan = 20
[random]
count = 6
speed = [8, 20]
"""
CLAIM = """
import importlib.metadata as metadata
known = metadata.version
metadata.version = lambda name: "0.0.1" if name == "trackweave" else known(name)
"""


class Machine:
    """A network namespace, and what runs in it."""

    def __init__(self, number: int, env: dict[str, str]) -> None:
        self.address, self.env = f"{NET}.{number}", env
        self.holder = subprocess.Popen(["unshare", "-n", "sleep", "100000"])
        time.sleep(0.5)
        here, there = f"here{number}", f"there{number}"
        for command in (
            f"ip link add {here} type veth peer name {there}",
            f"ip link set {here} master {BRIDGE} up",
            f"ip link set {there} netns {self.holder.pid}",
        ):
            subprocess.run(command.split(), check=True)
        for command in (
            "ip link set lo up",
            f"ip address add {self.address}/24 dev {there}",
            f"ip link set {there} up",
        ):
            self.run(command.split())

    def inside(self, command: list[str]) -> list[str]:
        """Return a command that is run on this machine."""
        return ["nsenter", "-t", str(self.holder.pid), "-n", *command]

    def run(self, command: list[str]) -> subprocess.CompletedProcess[str]:
        """Run a command on this machine to its end."""
        return subprocess.run(
            self.inside(command), env=self.env, capture_output=True, text=True, check=False
        )

    def join(self, options: str) -> None:
        """Start Ray here."""
        given = f"--node-ip-address {self.address} --disable-usage-stats {options}"
        done = self.run(["ray", "start", *given.split()])
        if done.returncode:
            raise SystemExit(f"{self.address}: {done.stdout}{done.stderr}")

    def processes(self) -> list[int]:
        """Return all processes of this machine's namespace but the one that holds it."""
        net = Path(f"/proc/{self.holder.pid}/ns/net").readlink()
        found = []
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                if (entry / "ns/net").readlink() == net and int(entry.name) != self.holder.pid:
                    found.append(int(entry.name))
            except OSError:  # it has ended meanwhile
                continue
        return found

    def kill(self) -> None:
        """End all of this machine's processes at once."""
        for pid in self.processes():
            os.kill(pid, signal.SIGKILL)


def write_input(folder: Path) -> None:
    """Write a recording of two regions and more, and a scene to study."""
    rng, n = np.random.default_rng(3), 1400
    x, y = np.linspace(-100e3, 100e3, n), rng.uniform(-20e3, 20e3, n)
    lines = ["time,x,y"]
    for scan in range(12):
        for at in np.flatnonzero(rng.random(n) < 0.95).tolist():
            east, north = rng.normal([x[at] + 200.0 * scan, y[at]], 20.0)
            lines.append(f"{scan},{east:.2f},{north:.2f}")
    (folder / "reports.csv").write_text("\n".join(lines) + "\n")
    (folder / "tracker.toml").write_text(TRACKER)
    (folder / "study.toml").write_text(STUDY)
    (folder / "scene.toml").write_text(SCENE)


def search(engine: str, out: Path) -> None:
    """Search a hard problem on islands, and write what comes of it."""
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
    from oracles.assignment import hard_tuples
    from trackweave.solvers import Annealing, Islands, TabuSearch

    islands = Islands((Annealing(), TabuSearch()), islands=3, epoch=3, epochs=3, engine=engine,
                      workers=3)  # fmt: skip
    answer = islands(hard_tuples(4, 1500, 20), rng=np.random.default_rng(3))
    out.mkdir()
    (out / "nodes").write_bytes(answer.nodes.tobytes() + repr(answer.certificate).encode())


def differing(one: Path, two: Path, names: tuple[str, ...]) -> list[str]:
    """Return which files of two results are not the same."""
    return [each for each in names if (one / each).read_bytes() != (two / each).read_bytes()]


def command_for(what: str, engine: str, out: Path) -> list[str]:
    """Return a command of trackweave on an engine."""
    if what == "islands":
        return [sys.executable, __file__, "--search", engine, str(out)]
    given = {"track": "track reports.csv --config tracker.toml", "study": "study study.toml"}[what]
    return ["trackweave", *given.split(), "--engine", engine, "--workers", "3", "--out", str(out)]


def compare(head: Machine, folder: Path) -> list[str]:
    """Run everything on both engines; return what is wrong."""
    wrong = []
    for what in ("track", "study", "islands"):
        outs = {engine: folder / f"{what}_{engine[:3]}" for engine in ("local", ENGINE)}
        for engine, out in outs.items():
            done = head.run(command_for(what, engine, out))
            if done.returncode:
                wrong.append(f"{what} on {engine}: exit {done.returncode}, {done.stderr[-600:]}")
        if wrong:
            return wrong
        names = {"track": BARE, "study": STUDIED, "islands": ("nodes",)}[what]
        odd = differing(outs["local"], outs[ENGINE], names)
        print(f"{what}: {', '.join(names)}:", odd or "the same bytes", flush=True)
        wrong += [f"{what}: {each}" for each in odd]
    return wrong


def lose_one(head: Machine, others: list[Machine], folder: Path) -> list[str]:
    """Kill the first machine that works while it does; return what is wrong."""
    out = folder / "killed"
    run = subprocess.Popen(head.inside(command_for("track", ENGINE, out)), env=head.env)
    lost = None
    while run.poll() is None and lost is None:
        time.sleep(0.05)
        lost = next((each for each in others if any(map(_is_at_work, each.processes()))), None)
    if lost is not None:
        time.sleep(0.3)
        lost.kill()
    code = run.wait()
    if code or lost is None:
        return [f"a machine killed: exit {code}, {lost and lost.address}"]
    odd = differing(folder / "track_loc", out, BARE)
    print("track, a machine killed at work:", odd or "the same bytes", flush=True)
    return [f"killed: {each}" for each in odd]


def _is_at_work(pid: int) -> bool:
    """Tell whether a process is an actor that serves."""
    try:
        return b"ray::_Room" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False


def refuse_another(head: Machine, folder: Path, env: dict[str, str]) -> list[str]:
    """Let a machine join that claims another trackweave; return what is wrong."""
    (folder / "claim").mkdir()
    (folder / "claim" / "sitecustomize.py").write_text(CLAIM)
    path = f"{folder / 'claim'}{os.pathsep}{env.get('PYTHONPATH', '')}"
    other = Machine(N_MACHINES + 1, {**env, "PYTHONPATH": path})
    other.join(f"--address {HEAD}:6379 --num-cpus 1")
    done = head.run(command_for("track", ENGINE, folder / "refused"))
    print("another version on one machine: exit", done.returncode, done.stderr.strip()[-250:])
    is_right = done.returncode == 2 and "0.0.1" in done.stderr
    return [] if is_right and not (folder / "refused").exists() else ["another version: accepted"]


def inside() -> int:
    """Set the machines up, do everything, and take them down."""
    folder = Path(tempfile.mkdtemp())
    env = {**os.environ, "RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    for command in (
        "ip link set lo up", f"ip link add {BRIDGE} type bridge", f"ip link set {BRIDGE} up",
    ):  # fmt: skip
        subprocess.run(command.split(), check=True)
    machines = [Machine(number, env) for number in range(1, N_MACHINES + 1)]
    head = machines[0]
    head.join("--head --port 6379 --num-cpus 0 --include-dashboard=false")
    for each in machines[1:]:
        each.join(f"--address {HEAD}:6379 --num-cpus 1")
    os.chdir(folder)
    write_input(folder)
    wrong = compare(head, folder)
    wrong = wrong or lose_one(head, machines[1:], folder) + refuse_another(head, folder, env)
    print("wrong:", wrong or "nothing")
    shutil.rmtree(folder, ignore_errors=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    if "--search" in sys.argv:
        sys.exit(search(sys.argv[-2], Path(sys.argv[-1])))
    if "--inside" in sys.argv:
        sys.exit(inside())
    alone = ["unshare", "-rnpf", "--mount-proc", "--kill-child"]
    sys.exit(subprocess.call([*alone, sys.executable, __file__, "--inside"]))
