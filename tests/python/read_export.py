"""Reads what `dorsum export` wrote with DuckDB, pandas and PyArrow and holds it against the recordings, bit for bit.

The recordings are read by the public packages `mcap` and `mcap-protobuf-support`, without our code.

usage: python read_export.py PARQUET_DIR CSV_DIR FILE.mcap...
"""

import glob
import json
import os
import struct
import sys
from urllib.parse import quote

import duckdb
import numpy
import pandas
import pyarrow.parquet
from google.protobuf.descriptor import FieldDescriptor
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

HIVE = "hive_partitioning = true, hive_types = {'participant': VARCHAR, 'session': VARCHAR}"


def bits(value):
    """A value that is equal only to one of the same bits: 0.0 is not -0.0, NaN is itself."""
    if isinstance(value, float):
        return struct.pack("<d", value)
    return value


def flat(message):
    """A tick as the columns of `ticks`, from the file's own schema."""
    row = {}
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            for axis in "xyz":
                row[f"{field.name}_{axis}"] = getattr(value, axis)
        elif field.type == FieldDescriptor.TYPE_ENUM:
            row[field.name] = field.enum_type.values_by_number[value].name
        else:
            row[field.name] = value
    return row


def recorded(path):
    """Metadata, ticks in the order written, and events of a recording."""
    ticks, events = [], []
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        metadata = list(reader.iter_metadata())[-1].metadata
        for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
            if channel.topic.startswith("/finger/"):
                ticks.append(flat(message))
            elif channel.topic == "/events":
                events.append((message.tick, message.time_ns, message.kind, message.text))
    return metadata, ticks, events


def key_of(metadata, path):
    """What the session is called: see `study::export`."""
    started = "".join(c for c in metadata["started_utc"] if c.isalnum())
    stem = os.path.splitext(os.path.basename(path))[0]
    return metadata.get("participant", "unknown"), f"{started}-{stem}"


def same_columns(what, columns, ticks):
    """Holds columns, lists of Python values by name, against recorded ticks."""
    assert list(columns) == list(ticks[0]), (what, list(columns))
    for name, values in columns.items():
        assert len(values) == len(ticks), (what, name, len(values), len(ticks))
        for i, (read, tick) in enumerate(zip(values, ticks)):
            assert bits(read) == bits(tick[name]), (what, name, i, read, tick[name])


def main(parquet, csv, paths):
    told = {"sessions": 0, "ticks": 0, "events": 0}
    parts = sorted(glob.glob(f"{parquet}/ticks/**/*.parquet", recursive=True))
    db = duckdb.connect()
    db.execute(f"CREATE VIEW ticks AS SELECT * FROM read_parquet('{parquet}/ticks/**/*.parquet', {HIVE})")
    db.execute(f"CREATE VIEW csv AS SELECT * FROM read_csv('{csv}/ticks/**/*.csv', {HIVE})")
    dataset = pandas.read_parquet(f"{parquet}/ticks")
    for path in paths:
        metadata, ticks, events = recorded(path)
        participant, session = key_of(metadata, path)
        where = "WHERE participant = ? AND session = ? ORDER BY tick, finger"
        for view in ["ticks", "csv"]:
            columns = ", ".join(f'"{name}"' for name in ticks[0])
            rows = db.execute(f"SELECT {columns} FROM {view} {where}", [participant, session]).fetchall()
            read = dict(zip(ticks[0], map(list, zip(*rows))))
            if view == "csv":
                # CSV does not say that a column is of single precision.
                read["duration_us"] = [float(numpy.float32(x)) for x in read["duration_us"]]
            same_columns(f"DuckDB, {view}", read, ticks)
        of_session = dataset[(dataset.participant == participant) & (dataset.session == session)]
        of_session = of_session.sort_values(["tick", "finger"]).drop(columns=["participant", "session"])
        same_columns("pandas", {c: of_session[c].tolist() for c in of_session}, ticks)
        place = f"/participant={quote(participant)}/session={quote(session)}/"
        part = next(p for p in parts if place in p)
        same_columns("PyArrow", pyarrow.parquet.ParquetFile(part).read().to_pydict(), ticks)
        frame = pandas.read_csv(
            part.replace(parquet, csv).replace(".parquet", ".csv"),
            dtype={"duration_us": numpy.float32},
        )
        same_columns("pandas, CSV", {c: frame[c].tolist() for c in frame}, ticks)

        read = db.execute(
            f"SELECT tick, time_ns, kind, text FROM '{parquet}/events.parquet' "
            "WHERE participant = ? AND session = ?",
            [participant, session],
        ).fetchall()
        assert read == events, (read, events)
        row = db.execute(
            f"SELECT pseudonym, ticks, rate_hz, started_utc FROM '{parquet}/sessions.parquet' "
            "WHERE participant = ? AND session = ?",
            [participant, session],
        ).fetchall()
        n = max(sum(t["finger"] == f for t in ticks) for f in range(4))
        assert row == [(metadata.get("participant"), n, float(metadata["rate_hz"]), metadata["started_utc"])], row
        told["sessions"] += 1
        told["ticks"] += len(ticks)
        told["events"] += len(events)

    # The gathered tables are the parts, whichever library puts them together.
    for table in ["events", "felt", "measures", "sessions"]:
        gathered = pandas.read_parquet(f"{parquet}/{table}.parquet")
        together = pandas.read_parquet(f"{parquet}/{table}")
        for frame in [gathered, together]:
            frame["participant"] = frame["participant"].astype(str)
            frame["session"] = frame["session"].astype(str)
        together = together[gathered.columns]
        by = list(gathered.columns)[:4]
        first, second = (f.sort_values(by).reset_index(drop=True) for f in [gathered, together])
        pandas.testing.assert_frame_equal(first, second, check_exact=True)

    # A query over the cohort, as a check that partitions are pruned and units are told.
    file = pyarrow.parquet.ParquetFile(parts[0])
    notes = {k.decode(): v.decode() for k, v in file.schema_arrow.metadata.items()}
    assert notes["dorsum.format"] == "1" and notes["unit.depth_mm"] == "mm", notes
    group = file.metadata.row_group(0)
    assert {group.column(i).compression for i in range(group.num_columns)} == {"ZSTD"}
    assert all(group.column(i).is_stats_set for i in range(group.num_columns))
    told["columns"] = group.num_columns
    json.dump(told, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
