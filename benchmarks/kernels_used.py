"""Which kernels a command, and all that it starts, took from the package, and which it did not.

Run it with a Python whose trackweave came from a wheel: python benchmarks/kernels_used.py COMMAND…
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from text_tables import heading

# Python imports a module of this name at its start; its ``atexit`` is there before any other.
HOOK = """
import atexit, json, os, sys
def tell():
    if "trackweave.kernel_cache" not in sys.modules:
        return
    from trackweave.warming.packing import kernels
    found = {f"{f.__module__}.{f.__qualname__}": dict(k._cache.came) for f, k in kernels()
             if k._cache.came}
    with open(os.environ["KERNELS_USED"], "a") as file:
        file.write(json.dumps(found) + "\\n")
atexit.register(tell)
"""


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "sitecustomize.py").write_text(HOOK, encoding="utf-8")
        told = place / "told.jsonl"
        told.touch()
        environment = os.environ | {"KERNELS_USED": str(told), "NUMBA_CACHE_DIR": f"{place}/kept"}
        paths = [folder, os.environ.get("PYTHONPATH", "")]
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        done = subprocess.run(sys.argv[1:], env=environment, check=False)
        runs = [json.loads(line) for line in told.read_text(encoding="utf-8").splitlines()]
    used = {name for run in runs for name in run}
    missed = {name for run in runs for name, came in run.items() if set(came) != {"shipped"}}
    print(heading(" ".join(["python benchmarks/kernels_used.py", *sys.argv[1:]])), end="\n\n")
    print(
        f"{len(runs)} processes used {len(used)} kernels; {len(used - missed)} of them came with "
        f"the package. Others: {', '.join(sorted(missed)) or 'none'}"
    )
    raise SystemExit(done.returncode)


if __name__ == "__main__":
    main()
