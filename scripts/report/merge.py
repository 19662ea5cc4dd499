#!/usr/bin/env python3
"""merge.py SHARD... --output FOLDER: joins the folders of all shards of a run (diffsac_eval --shard i/n), in any order: the numbers are those of a
run without shards, times excepted. `python3 scripts/report FOLDER` then makes its tables."""
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

ENDS = {"structure_values": "structures_end"}  # Of lists without ends of their own.


class Bad(Exception):
    pass


def check_alike(first, other):
    both = f"{first['called']} and {other['called']}"
    if first["shard"]["count"] != other["shard"]["count"]:
        raise Bad(f"{both} are parts of different splits")
    for what, keys in (("have different configurations", ("configuration",)), ("were run differently", ("setup",)), ("saw different data", ("dataset", "conditions"))):
        a, b = (runs.flat({key: facts[key] for key in keys}) for facts in (first, other))
        for key in {**a, **b}:
            if a.get(key) != b.get(key) and key != "configuration.threads":
                raise Bad(f"{both} {what}: {key}: {a.get(key)} and {b.get(key)}")
    if first["git_revision"] != other["git_revision"]:
        print(f"merge: {both} were run by different programs, git {first['git_revision']} and {other['git_revision']}", file=sys.stderr)


def read_shards(folders):
    """run.json of each shard by its number, each exactly once."""
    shards = {}
    for folder in folders:
        facts = runs.read_facts(folder)
        if not facts.get("shard"):
            raise Bad(f"'{folder}' is no shard: diffsac_eval --shard i/n makes them")
        number, count = facts["shard"]["index"], facts["shard"]["count"]
        facts.update(folder=folder, called=f"{folder} (shard {number}/{count})")
        if facts["partial"]:
            raise Bad(f"{facts['called']} was interrupted; run that shard again")
        if number in shards:
            raise Bad(f"{shards[number]['folder']} and {folder} are both shard {number}/{count}")
        shards[number] = facts
    shards = [shards[number] for number in sorted(shards)]
    for other in shards[1:]:
        check_alike(shards[0], other)
    count = shards[0]["shard"]["count"]
    absent = sorted(set(range(1, count + 1)) - {facts["shard"]["index"] for facts in shards})
    if absent:
        raise Bad(f"shard {absent[0]}/{count} is missing; given are {len(shards)} of {count}")
    return shards


def joined_problems(shards):
    """The lines of problems.csv as they are, by condition, method and place in the data."""
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
                raise Bad(f"method '{method['name']}', condition '{condition['name']}': the shards' records are not the {expected} problems, each once")
            order.append(own)
    return pd.concat(order)


# --- estimates.h5 ---


def records_of(group):
    """The columns of one method on one condition as a dictionary a record."""
    columns = {name: data[()] for name, data in group.items()}
    lists = {name: columns[ends] for name in columns if (ends := ENDS.get(name, name + "_end")) in columns}
    for i in range(len(columns["index"])):
        yield {name: values[lists[name][i - 1] if i else 0:lists[name][i]] if name in lists else values[i]
               for name, values in columns.items() if not name.endswith("_end")}


def copy_attributes(source, target):
    for name, value in source.attrs.items():
        target.attrs.create(name, value, dtype=source.attrs.get_id(name).dtype)


def put(group, name, values, dtype):
    packed = {"chunks": (1 << 14,), "compression": 4} if values.ndim == 1 and len(values) > 1 << 14 and values.dtype != object else {}
    group.create_dataset(name, data=values, dtype=dtype, **packed)


def join_group(sources, target):
    copy_attributes(sources[0], target)
    records = sorted((record for source in sources for record in records_of(source)), key=lambda record: record["index"])
    models = {}  # A dataset of each name: some shards may lack one.
    for source in sources:
        for name, data in source.items():
            models.setdefault(name, data)
    for name, model in models.items():
        if name.endswith("_end"):
            column = next((one for one in (name.removesuffix("_end"), "structures") if one in models))
            put(target, name, np.cumsum([len(record.get(column, ())) for record in records]).astype(np.int64), model.dtype)
        elif ENDS.get(name, name + "_end") in models:
            empty = np.zeros((0, *model.shape[1:]), model.dtype)
            put(target, name, np.concatenate([record.get(name, empty) for record in records]), model.dtype)
        elif model.ndim == 2:
            width = max(source[name].shape[1] for source in sources if name in source)
            rows = np.full((len(records), width), np.nan)
            for row, record in zip(rows, records):
                row[:len(record.get(name, ()))] = record.get(name, ())
            put(target, name, rows, model.dtype)
        else:
            put(target, name, np.array([record.get(name, np.zeros((), model.dtype)[()]) for record in records], model.dtype), model.dtype)


def join_examples(sources, target):
    """Their points with new numbers, in the order of conditions and data."""
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
    """Nothing where the run keeps none."""
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
    try:
        merge(arguments.shards, arguments.output)
    except (Bad, OSError, KeyError, ValueError) as error:
        sys.exit(f"merge: {error}")


if __name__ == "__main__":
    files.run_script(main)
