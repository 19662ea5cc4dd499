"""to_tensorboard.py RUN... && tensorboard --logdir runs: event files for TensorBoard, of the metrics.csv of trainings' folders."""
import argparse
import csv
import glob
import os
import sys
import time

try:
    from tensorboard.compat.proto.event_pb2 import Event
    from tensorboard.compat.proto.summary_pb2 import Summary
    from tensorboard.summary.writer.event_file_writer import EventFileWriter
except ImportError as error:
    sys.exit(f"to_tensorboard.py: {error}; TensorBoard's package has it: pip install tensorboard")

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--follow", type=float, help="go on, and look for new rows after so many seconds")
parser.add_argument("runs", nargs="+", metavar="RUN", help="folder of a training")
arguments = parser.parse_args()
writers, last = {}, dict.fromkeys(arguments.runs, 0)
while not writers or (arguments.follow and not time.sleep(arguments.follow)):
    for run in arguments.runs:
        try:
            with open(os.path.join(run, "metrics.csv"), encoding="utf-8") as file:
                rows = [row for row in csv.DictReader(file) if int(row["iteration"]) > last[run]]
        except OSError as error:
            sys.exit(f"to_tensorboard.py: {error}")
        if run not in writers:
            for earlier in glob.glob(os.path.join(glob.escape(run), "events.out.tfevents.*")):
                os.remove(earlier)
            writers[run] = EventFileWriter(run)
        for row in rows:
            last[run] = int(row.pop("iteration"))
            values = [Summary.Value(tag=name, simple_value=float(value)) for name, value in row.items() if value]
            writers[run].add_event(Event(wall_time=time.time(), step=last[run], summary=Summary(value=values)))
        writers[run].flush()
