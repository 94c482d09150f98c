"""Writes runs as MCAP, a log format that Foxglove and PlotJuggler open: one channel per run, one JSON message per row."""

import json
import math

from mcap.writer import Writer

from .runs import PlotError


def write(runs, out):
    """All columns of `runs`; the time of a message is t_s from the start of the run, and null is an empty field."""
    with open(out, "wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="tribo")
        for run in runs:
            if min(run["t_s"]) < 0.0:
                raise PlotError(f"{run.name}: t_s is {min(run['t_s']):g} s; MCAP has no time before 0")
            names = list(run.columns)
            schema = {"type": "object", "properties": {name: {"type": "number"} for name in names}}
            schema_id = writer.register_schema(name=f"tribo.{run.name}", encoding="jsonschema", data=json.dumps(schema).encode())
            channel = writer.register_channel(topic=f"/{run.name}", message_encoding="json", schema_id=schema_id)
            for row in zip(*run.columns.values()):
                message = {name: value if math.isfinite(value) else None for name, value in zip(names, row)}
                time_ns = round(1e9 * message["t_s"])
                writer.add_message(channel, log_time=time_ns, publish_time=time_ns, data=json.dumps(message).encode())
        writer.finish()
