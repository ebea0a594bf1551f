"""A cohort too large for one machine, by example: one process of `dorsum` for each recording, then questions to the tables.

Every process writes into folders of its own, told by participant and session, so that any engine may spread them: nothing is
shared but the folder, and whoever runs a file twice changes nothing. Here the engine is Python's own; with others only the
line that maps changes:

    concurrent.futures   list(pool.map(hand_on, files))
    Dask                 dask.bag.from_sequence(files).map(hand_on).compute()
    Spark                spark.sparkContext.parallelize(files, len(files)).map(hand_on).collect()
    Slurm and the like   one job a file: dorsum export FILE --parquet DIR --part --jobs 1

DuckDB reads the tables where they lie, however many there are, and reads only the participants and columns it is asked for.
Spark reads the same folders: spark.read.parquet("DIR/ticks") has the columns participant and session (tell it
spark.sql.sources.partitionColumnTypeInference.enabled=false where all pseudonyms are numbers).

usage: python cohort.py DORSUM RECORDINGS DIR [PROCESSES]
"""

import concurrent.futures
import glob
import json
import os
import subprocess
import sys

import duckdb


def hand_on(task):
    """One recording by one process; what it said, or why it did not."""
    dorsum, file, folder = task
    command = [dorsum, "export", file, "--parquet", folder, "--part", "--jobs", "1", "--json"]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode == 0:
        return json.loads(run.stdout)["sessions"][0]
    return {"file": file, "error": run.stderr.strip()}


def tables(folder):
    """The tables of a folder as views."""
    db = duckdb.connect()
    for name in ["ticks", "events", "felt", "measures", "sessions"]:
        db.execute(
            f"CREATE VIEW {name} AS SELECT * FROM read_parquet('{folder}/{name}/*/*/*.parquet', "
            "hive_partitioning = true, hive_types = {'participant': VARCHAR, 'session': VARCHAR})"
        )
    return db


QUESTIONS = {
    "how hard each participant pressed": """
        SELECT participant, count(*) AS sessions, round(max(peak_force_n), 3) AS peak_force_n,
               round(avg(sparc), 3) AS smoothness
        FROM sessions GROUP BY participant ORDER BY participant""",
    "share of the time on the skin that was search": """
        SELECT participant, round(sum(contact_s) FILTER (part = 'search') / sum(contact_s) FILTER (part = 'whole'), 3) AS search
        FROM measures WHERE finger IS NULL GROUP BY participant ORDER BY participant""",
    "ticks in which a finger was pressed in deeper than 2 mm": """
        SELECT participant, finger, count(*) AS ticks
        FROM ticks WHERE depth_mm > 2 GROUP BY participant, finger ORDER BY participant, finger""",
}


def main(dorsum, recordings, folder, processes=None):
    files = sorted(glob.glob(f"{recordings}/**/*.mcap", recursive=True))
    tasks = [(dorsum, file, folder) for file in files]
    with concurrent.futures.ThreadPoolExecutor(int(processes or os.cpu_count())) as pool:
        told = list(pool.map(hand_on, tasks))
    answers = {}
    db = tables(folder)
    for question, query in QUESTIONS.items():
        answer = db.execute(query)
        names = [column[0] for column in answer.description]
        answers[question] = [dict(zip(names, row)) for row in answer.fetchall()]
    refused = {t["file"]: t["error"] for t in told if t.get("error")}
    json.dump({"files": len(files), "refused": refused, "answers": answers}, sys.stdout, indent=1)


if __name__ == "__main__":
    main(*sys.argv[1:])
