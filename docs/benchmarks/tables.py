"""Turn pytest-benchmark's JSON into the tables and pictures of the page on benchmarks.

``python docs/benchmarks/tables.py FILE.json...`` writes beside this file.
Times are the least CPU time of several rounds.
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
OURS = "ocp-traj"
PRINTED = {
    "toppra-kinematics": 3.5161843726374564,
    "moveit-test1": 40.080256821829849,
    "moveit-test3": 1919.5597888812974,
}
"""toppra 0.6 with 500 cells a gap; what MoveIt's own tests expect."""
GIVEN = "our waypoint times"
"""A setting no user of that peer has; in the table only."""
MARKERS = {
    OURS: ("o", "#0b6e4f"),
    "Drake": ("s", "#3366aa"),
    "pyroboplan": ("^", "#8844aa"),
    "Ruckig": ("D", "#cc3311"),
    "toppra": ("v", "#b8860b"),
    "TOTG": ("P", "#555555"),
}


def read(path: str) -> list[dict[str, Any]]:
    entries = json.loads(Path(path).read_text())["benchmarks"]
    return [{"test": e["name"], "seconds": e["stats"]["min"], **e["extra_info"]} for e in entries]


def write(name: str, header: list[str], rows: list[list[str]]) -> None:
    with (HERE / name).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    print(f"{name}: {len(rows)} rows")


def judged(entry: dict[str, Any]) -> str:
    if entry["duration"] is None:
        return entry["message"] or "no motion"
    if "feasible" not in entry:
        return "no curve to judge"
    if entry["feasible"]:
        return "feasible"
    if entry["worst_ratio"] > 1.0 + 1e-6:
        return f"{entry['worst_limit']} {100 * (entry['worst_ratio'] - 1):.2g} % over"
    return entry["findings"][0] if entry["findings"] else "not feasible"


def peer_table(entries: list[dict[str, Any]], jerk: bool) -> list[dict[str, Any]]:
    chosen = [entry for entry in entries if entry["jerk"] is jerk]
    rows = []
    for case in dict.fromkeys(entry["case"] for entry in chosen):
        group = [entry for entry in chosen if entry["case"] == case]
        best = min(entry["duration"] for entry in group if entry["peer"] == OURS)
        for entry in sorted(group, key=lambda e: (e["duration"] is None, e["duration"])):
            duration = entry["duration"]
            rows.append(
                [
                    f"`{case}`",
                    f"**{entry['peer']}**" if entry["peer"] == OURS else entry["peer"],
                    entry["setting"],
                    "" if duration is None else f"{duration:.4f}",
                    "" if duration is None else f"{100 * (duration / best - 1):+.2f} %",
                    f"{1e3 * entry['seconds']:.3g}",
                    judged(entry),
                ]
            )
    header = ["case", "method", "setting", "duration, s", "against ours", "CPU, ms", "our audit"]
    write("with-jerk.csv" if jerk else "without-jerk.csv", header, rows)
    return chosen


def core_tables(entries: list[dict[str, Any]]) -> None:
    cases, waypoints, examples = [], [], []
    for entry in entries:
        time = f"{1e3 * entry['seconds']:.3g}"
        if "milliseconds_a_waypoint" in entry:
            count = entry["test"].split("[")[1].rstrip("]")
            per_step = f"{entry['microseconds_an_iteration_and_waypoint']:.0f}"
            waypoints.append(
                [count, time, entry["iterations"], f"{entry['milliseconds_a_waypoint']:.2f}", per_step]
            )
            continue
        if "lower" in entry:
            task = entry["test"].split("[")[1].rstrip("]")
            printed = f"{PRINTED[task]:.7g}"
            examples.append([task, printed, f"{entry['duration']:.7g}", f"{entry['lower']:.7g}", time])
            continue
        reached, wanted = f"{entry['duration']:.4f} s", ""
        if "longest_wanted" in entry:
            wanted = f"at most {entry['longest_wanted']:g} s"
        if "estimate" in entry:
            wanted = f"{entry['estimate']:.4f} s estimated; {100 * entry['above']:.2f} % above"
        if "most_wanted" in entry:
            reached, wanted = (
                f"{entry['energy']:.3f} J in {reached}",
                f"at most {entry['most_wanted']:.2f} J",
            )
        aim = f"{1e3 * entry['aim_seconds']:g}" if "aim_seconds" in entry else ""
        name = entry["test"].removeprefix("test_").replace("_", " ")
        cases.append([name, reached, wanted, time, aim, entry["iterations"]])
    write("core.csv", ["what", "reached", "wanted", "CPU, ms", "aim, ms", "last iterations"], cases)
    header = ["waypoints", "CPU, ms", "iterations", "ms a waypoint", "µs an iteration and waypoint"]
    write("waypoints.csv", header, waypoints)
    header = ["problem", "the peer's, s", "ours, s", "certified lower bound, s", "our CPU, ms"]
    write("examples.csv", header, examples)


def picture(entries: list[dict[str, Any]], name: str, title: str) -> None:
    entries = [entry for entry in entries if not entry["setting"].startswith(GIVEN)]
    entries = [entry for entry in entries if not entry["case"].endswith("-free-ends")]
    cases = list(dict.fromkeys(entry["case"] for entry in entries))
    figure, panels = plt.subplots(1, len(cases), figsize=(3.4 * len(cases), 3.6), squeeze=False)
    for panel, case in zip(panels[0], cases):
        for entry in entries:
            if entry["case"] == case and entry["duration"] is not None:
                marker, colour = MARKERS[entry["peer"]]
                broken = not entry.get("feasible", False)
                face = "none" if broken else colour
                panel.plot(
                    1e3 * entry["seconds"],
                    entry["duration"],
                    marker,
                    color=colour,
                    markerfacecolor=face,
                    ms=8,
                    mew=1.5,
                )
        panel.set_xscale("log")
        panel.set_title(case, fontsize=10)
        panel.set_xlabel("CPU time, ms")
        panel.grid(alpha=0.3)
    panels[0, 0].set_ylabel("duration of the motion, s")
    present = [peer for peer in MARKERS if any(entry["peer"] == peer for entry in entries)]
    handles = [
        plt.Line2D([], [], marker=MARKERS[p][0], color=MARKERS[p][1], ls="", ms=8, label=p) for p in present
    ]
    figure.suptitle(title, fontsize=11)
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), frameon=False)
    figure.tight_layout(rect=(0, 0.08, 1, 1))
    figure.savefig(HERE / name, dpi=150)
    print(name)


def main() -> None:
    by_name = {entry["test"]: entry for path in sys.argv[1:] for entry in read(path)}  # later files win
    entries = list(by_name.values())
    core_tables([entry for entry in entries if "peer" not in entry])
    peers = [entry for entry in entries if "peer" in entry]
    title = "Velocity, acceleration and jerk limits (lower left is better)"
    picture(peer_table(peers, True), "with-jerk.png", title)
    title = "Velocity and acceleration limits (lower left is better)"
    picture(peer_table(peers, False), "without-jerk.png", title)


if __name__ == "__main__":
    main()
