"""Holds a dataset of `dorsum export --bids` against the BIDS schema and, where it runs, the BIDS validator.

usage: python check_bids.py DATASET
"""

import csv
import glob
import json
import os
import shutil
import subprocess
import sys

from bidsschematools.schema import load_schema
from bidsschematools.validator import validate_bids


def names_are_valid(dataset):
    """Every file name is one that the schema knows."""
    paths = [p for p in glob.glob(f"{dataset}/**", recursive=True) if os.path.isfile(p)]
    result = validate_bids(dataset)
    assert not result["path_tracking"], result["path_tracking"]
    return len(paths)


def motion_is_valid(dataset, schema):
    """Sidecars have what the schema requires, counts agree with channels, samples with both."""
    sidecars = glob.glob(f"{dataset}/sub-*/ses-*/motion/*_motion.json")
    rules = schema["rules"]["sidecars"]["motion"]
    types = set(schema["objects"]["columns"]["type__channels"]["enum"]) if "enum" in schema["objects"]["columns"]["type__channels"] else None
    for path in sidecars:
        sidecar = json.load(open(path))
        for rule in rules.values():
            for field, level in rule["fields"].items():
                level = level if isinstance(level, str) else level["level"]
                assert level != "required" or field in sidecar, (path, field)
                assert level != "deprecated" or field not in sidecar, (path, field)
        with open(path.replace("_motion.json", "_channels.tsv")) as file:
            rows = list(csv.DictReader(file, delimiter="\t"))
        required = schema["rules"]["tabular_data"]["motion"]["motionChannels"]
        columns = list(rows[0])
        first = [name.split("__")[0] for name in required["initial_columns"]]
        assert columns[: len(first)] == first, columns
        counts = {}
        for row in rows:
            counts[row["type"]] = counts.get(row["type"], 0) + 1
        for kind in ["POS", "VEL", "LATENCY", "ACCEL", "ANGACCEL", "GYRO", "JNTANG", "MAGN", "ORNT"]:
            assert sidecar[f"{kind}ChannelCount"] == counts.get(kind, 0), (kind, counts)
        assert sidecar["MiscChannelCount"] == counts["MISC"], counts
        assert sidecar["MotionChannelCount"] == len(rows)
        points = {r["tracked_point"] for r in rows if r["type"] == "POS"}
        assert sidecar["TrackedPointsCount"] == len(points)
        assert len({r["name"] for r in rows}) == len(rows), "names are single"
        assert types is None or {r["type"] for r in rows} <= types
        latency = [i for i, r in enumerate(rows) if r["type"] == "LATENCY"]
        before = -1.0
        with open(path.replace(".json", ".tsv")) as file:
            for line in file:
                cells = line.rstrip("\n").split("\t")
                assert len(cells) == len(rows), (path, len(cells))
                assert all(c == "n/a" or float(c) == float(c) for c in cells)
                now = float(cells[latency[0]])
                assert now > before, (path, now)
                before = now
    return len(sidecars)


def validator_says(dataset):
    """Errors and warnings of the BIDS validator; None where it is not to be had or cannot fetch its schema."""
    program = os.path.join(os.path.dirname(sys.executable), "bids-validator-deno")
    program = program if os.path.exists(program) else shutil.which("bids-validator-deno")
    if not program:
        return None
    run = subprocess.run([program, dataset, "--json"], capture_output=True, text=True)
    try:
        issues = json.loads(run.stdout)["issues"]["issues"]
    except (json.JSONDecodeError, KeyError):
        print(f"the validator did not run: {run.stderr.strip()[-400:]}", file=sys.stderr)
        return None
    told = {"errors": [], "warnings": []}
    for issue in issues:
        kind = {"error": "errors", "warning": "warnings"}.get(issue["severity"])
        if kind:
            told[kind].append({k: issue.get(k) for k in ["code", "subCode", "location", "issueMessage"]})
    return told


def main(dataset):
    told = {"files": names_are_valid(dataset), "sessions": motion_is_valid(dataset, load_schema().to_dict())}
    told["validator"] = validator_says(dataset)
    json.dump(told, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
