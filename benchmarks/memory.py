#!/usr/bin/env python3
"""Does the memory of a batch evaluation stay what it is? Resident memory over the run.

usage: benchmarks/memory.py [CONFIG.yaml] [--problems 100000] [--points 50] [--rows ransac_100,diffsac] [--threads 2]
                            [--eval build/release/bin/diffsac_eval]

Prints seconds since the start and MiB at twenty moments and at the end, and the size of what was written. Linux and
Python 3 alone.
"""

import argparse
import pathlib
import subprocess
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent


def resident(pid):
    """MiB now and at most; None when the process is gone."""
    try:
        text = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return None
    of = {line.split(":")[0]: line.split()[1] for line in text.splitlines() if line.startswith(("VmRSS", "VmHWM"))}
    return (int(of["VmRSS"]) // 1024, int(of["VmHWM"]) // 1024) if len(of) == 2 else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config", nargs="?", default=str(HERE / "large/line.yaml"))
    parser.add_argument("--problems", type=int, default=100000)
    parser.add_argument("--points", type=int, default=50)
    parser.add_argument("--rows", default="ransac_100,diffsac")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--eval", default=str(HERE.parent / "build/release/bin/diffsac_eval"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        started = time.time()
        process = subprocess.Popen(
            [arguments.eval, "--config", arguments.config, "--methods", arguments.rows, "--threads", str(arguments.threads),
             "--device", "cpu", "--output", folder, "--set", f"problems={arguments.problems}", "--set",
             f"data.num_points={arguments.points}"], stdout=subprocess.DEVNULL)
        samples = []
        while process.poll() is None:
            now = resident(process.pid)
            if now:
                samples.append((time.time() - started, *now))
            time.sleep(0.2)
        written = sum(path.stat().st_size for path in pathlib.Path(folder).rglob("*") if path.is_file())
    if process.returncode != 0 or not samples:
        raise SystemExit(f"diffsac_eval ended with status {process.returncode}")
    print("| seconds | MiB | MiB at most so far |\n|---|---|---|")
    for k in range(21):
        print("| {:.0f} | {} | {} |".format(*samples[(len(samples) - 1) * k // 20]))
    print(f"\n{written / 2**20:.0f} MiB written")


if __name__ == "__main__":
    main()
