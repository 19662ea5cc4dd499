#!/usr/bin/env python3
"""merge.py SHARD... --output FOLDER: joins the folders of all shards of a run (diffsac_eval --shard i/n), in any order. All numbers but times equal
those of a run without shards. `python3 scripts/report FOLDER` then makes the tables."""
import argparse
import io
import json
import os
import shutil
import sys

import h5py
import numpy as np
import pandas as pd

import files
import runs
from files import BadInput

ENDS = {"structure_values": "structures_end"}  # Of lists without ends of their own.


def check_alike(first, other):
    both = f"{first['called']} and {other['called']}"
    if first["shard"]["count"] != other["shard"]["count"]:
        raise BadInput(f"{both} are parts of different splits")
    for what, keys in (("have different configurations", ("configuration",)), ("were run differently", ("setup",)), ("saw different data", ("dataset", "conditions"))):
        a, b = (runs.flat({key: facts[key] for key in keys}) for facts in (first, other))
        for key in {**a, **b}:
            if a.get(key) != b.get(key) and key != "configuration.threads":
                raise BadInput(f"{both} {what}: {key}: {a.get(key)} and {b.get(key)}")
    if first["git_revision"] != other["git_revision"]:
        print(f"merge: {both} were run by different programs, git {first['git_revision']} and {other['git_revision']}", file=sys.stderr)


def read_shards(folders):
    """Reads run.json of all shards. Each shard must be given exactly once."""
    shards = {}
    for folder in folders:
        facts = runs.read_facts(folder)
        if not facts.get("shard"):
            raise BadInput(f"'{folder}' is no shard: diffsac_eval --shard i/n makes them")
        number, count = facts["shard"]["index"], facts["shard"]["count"]
        facts.update(folder=folder, called=f"{folder} (shard {number}/{count})")
        if facts["partial"]:
            raise BadInput(f"{facts['called']} was interrupted; run that shard again")
        if number in shards:
            raise BadInput(f"{shards[number]['folder']} and {folder} are both shard {number}/{count}")
        shards[number] = facts
    shards = [shards[number] for number in sorted(shards)]
    for other in shards[1:]:
        check_alike(shards[0], other)
    count = shards[0]["shard"]["count"]
    absent = sorted(set(range(1, count + 1)) - {facts["shard"]["index"] for facts in shards})
    if absent:
        raise BadInput(f"shard {absent[0]}/{count} is missing; given are {len(shards)} of {count}")
    return shards


def joined_problems(shards):
    """Joins the lines of problems.csv, unchanged, by condition, method and place in the data."""
    tables = [pd.read_csv(os.path.join(facts["folder"], "problems.csv"), dtype=str, keep_default_na=False) for facts in shards]
    table = pd.concat(tables, ignore_index=True).fillna("")
    facts, order = shards[0], []
    for c, condition in enumerate(facts["conditions"]):
        for m, method in enumerate(facts["methods"]):
            own = table[(table["condition"] == condition["name"]) & (table["method"] == method["name"])]
            own = own.iloc[own["index"].astype(int).argsort(kind="stable")]
            expected = condition["problems"] if not method["conditions"] or condition["name"] in method["conditions"] else 0
            expected = min(expected, method["max_problems"] or expected)
            if own["index"].astype(int).tolist() != list(range(expected)):
                raise BadInput(f"method '{method['name']}', condition '{condition['name']}': the shards' records are not the {expected} problems, each once")
            order.append(own)
    return pd.concat(order)


# --- estimates.h5 ---


def copy_attributes(source, target):
    for name, value in source.attrs.items():
        target.attrs.create(name, value, dtype=source.attrs.get_id(name).dtype)


def put(group, name, values, dtype):
    packed = {"chunks": (1 << 14,), "compression": 4} if values.ndim == 1 and len(values) > 1 << 14 and values.dtype != object else {}
    group.create_dataset(name, data=values, dtype=dtype, **packed)


def join_group(sources, target):
    """Joins the columns of one method on one condition in the order of the data. Shards may lack optional columns."""
    copy_attributes(sources[0], target)
    order = np.argsort(np.concatenate([source["index"][()] for source in sources]), kind="stable")
    columns = {name: data for source in sources for name, data in source.items()}
    for name, model in ((name, data) for name, data in columns.items() if not name.endswith("_end")):
        ends, values = ENDS.get(name, name + "_end"), []
        is_list = ends in columns
        nothing = np.zeros((0, *model.shape[1:]), model.dtype) if is_list else np.zeros(0) if model.ndim == 2 else np.zeros((), model.dtype)[()]
        for source in sources:
            if name not in source:
                values += [nothing] * len(source["index"])
            else:
                values += np.split(source[name][()], source[ends][:-1]) if is_list else list(source[name][()])
        values = [values[i] for i in order]
        if is_list:
            put(target, name, np.concatenate(values), model.dtype)
            if ends not in target:
                put(target, ends, np.cumsum([len(one) for one in values]).astype(np.int64), np.int64)
        elif model.ndim == 2:
            rows = np.full((len(values), max(len(one) for one in values)), np.nan)
            for row, one in zip(rows, values):
                row[:len(one)] = one
            put(target, name, rows, model.dtype)
        else:
            put(target, name, np.array(values, model.dtype), model.dtype)


def join_examples(sources, target):
    """Joins examples in the order of conditions and data, with new numbers."""
    contents = [json.loads(source["json"][()].tobytes()) for source in sources]
    places = sorted((one["condition"], one["index"], s, i) for s, content in enumerate(contents) for i, one in enumerate(content["examples"]))
    number = {place[2:]: n for n, place in enumerate(places)}
    for (s, i), n in number.items():
        for name in ("points", "image_points", "source", "inliers"):
            if f"{name}-{i}" in sources[s]:
                sources[s].copy(f"{name}-{i}", target, f"{name}-{n}")
    joined = {"examples": [contents[s]["examples"][i] for _, _, s, i in places],
              "traces": sorted(({**one, "example": number[s, one["example"]]} for s, content in enumerate(contents) for one in content["traces"]),
                               key=lambda one: (one["condition"], one["index"]))}
    target.create_dataset("json", data=np.frombuffer(json.dumps(joined).encode(), sources[0]["json"].dtype))


def join_estimates(folders, path):
    """Joins estimates.h5, if the run has one."""
    sources = [h5py.File(os.path.join(folder, "estimates.h5"), "r") for folder in folders if os.path.exists(os.path.join(folder, "estimates.h5"))]
    if not sources:
        return files.remove(path)
    content = io.BytesIO()
    with h5py.File(content, "w") as target:
        copy_attributes(sources[0], target)
        for method in dict.fromkeys(name for source in sources for name in source):
            own = [source[method] for source in sources if method in source]
            if method == "examples":
                join_examples(own, target.create_group(method))
                continue
            for condition in dict.fromkeys(name for group in own for name in group):
                join_group([group[condition] for group in own if condition in group], target.create_group(f"{method}/{condition}"))
    files.write_whole(path, content.getvalue())


def joined_facts(shards):
    first, curves = shards[0], {}
    for facts in shards:
        for curve in facts["reliability"]:
            scenes = curves.setdefault((curve["label"], curve["condition"]), {})
            for scene, bins in curve["scenes"].items():
                scenes[scene] = (np.array(bins) + scenes.get(scene, 0)).tolist()
    machines = dict.fromkeys(facts["machine"] for facts in shards)
    took = {"seconds": sum(facts["facts"]["seconds"] for facts in shards), "peak_memory_mib": max(facts["facts"]["peak_memory_mib"] for facts in shards)}
    joined = {key: value for key, value in first.items() if key not in ("folder", "called")}
    return {**joined, "shard": None, "machine": f"{'; '.join(machines)} ({len(shards)} shards)", "facts": {**first["facts"], **took},
            "reliability": [{"label": label, "condition": condition, "scenes": scenes} for (label, condition), scenes in curves.items()]}


def merge(folders, output):
    shards = read_shards(folders)
    problems = joined_problems(shards)
    os.makedirs(output, exist_ok=True)
    files.remove(os.path.join(output, "run.json"))  # Comes last: a folder with one is a run.
    files.write_whole(os.path.join(output, "problems.csv"), problems.to_csv(index=False, lineterminator="\n"))
    join_estimates([facts["folder"] for facts in shards], os.path.join(output, "estimates.h5"))
    shutil.copyfile(os.path.join(shards[0]["folder"], "config.yaml"), os.path.join(output, "config.yaml"))
    files.write_whole(os.path.join(output, "run.json"), json.dumps(joined_facts(shards), ensure_ascii=False, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("shards", nargs="+", metavar="SHARD")
    parser.add_argument("--output", required=True, help="the whole run's folder")
    arguments = parser.parse_args()
    merge(arguments.shards, arguments.output)


if __name__ == "__main__":
    files.run_script(main)
