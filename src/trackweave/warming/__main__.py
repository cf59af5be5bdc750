"""``python -m trackweave.warming PART FOLDER``: what the build of a wheel runs.

Compiles what a part reaches, into NUMBA_CACHE_DIR, and packs it into a folder.
"""

import sys
from pathlib import Path

from trackweave.warming.covering import tasks_of
from trackweave.warming.packing import forget_places, pack

if __name__ == "__main__":
    part, folder = sys.argv[1:]
    forget_places()
    for _, run in tasks_of(part):
        run()
    pack(Path(folder))
