"""The command ``warm``: compile now what later commands need, and say where kernels come from."""

from collections import Counter
from typing import Any

from trackweave.cli.edge import Voice
from trackweave.kernel_cache import FOLDER, machine, why_not_shipped
from trackweave.warming.covering import tasks_of
from trackweave.warming.packing import kernels

__all__ = ["run_warm"]


def run_warm(voice: Voice, *, everything: bool = False) -> dict[str, Any]:
    """Run what reaches kernels; return how many were shipped, kept and compiled, and where."""
    tasks = tasks_of("all" if everything else "first")
    with voice.progress("warming") as progress:
        for done, (_, run) in enumerate(tasks, start=1):
            run()
            if progress is not None:
                progress(done, len(tasks))
    found = _found()
    obstacle = found["why_not_shipped"]
    voice.say(
        f"used {found['shipped']} kernels that came with the package"
        + (f" ({obstacle})" if obstacle else f" ({found['shipped_folder']})")
        + f", {found['kept']} kept from earlier runs, {found['compiled']} compiled now"
    )
    for folder in found["kept_folders"]:
        voice.say(f"kept in {folder}")
    return found


def _found() -> dict[str, Any]:
    """Return where the kernels of this process came from."""
    came: Counter[str] = Counter()
    folders, compiled = set(), []
    for function, kernel in kernels():
        own = kernel._cache.came  # noqa: SLF001 ours
        came += own
        if own["kept"] or own["compiled"]:
            folders.add(kernel._cache.cache_path)  # noqa: SLF001
        if own["compiled"]:
            compiled.append(f"{function.__module__}.{function.__qualname__}")
    return {
        "shipped": came["shipped"],
        "kept": came["kept"],
        "compiled": came["compiled"],
        "shipped_folder": str(FOLDER) if FOLDER.is_dir() else None,
        "kept_folders": sorted(str(folder) for folder in folders if folder),
        "why_not_shipped": why_not_shipped(),
        "compiled_kernels": sorted(compiled),
        **machine(),
    }
