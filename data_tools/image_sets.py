"""Makes the matches of the image sets that a file lists (configs/sets.yaml), by diffsac_prepare and the converters of this folder."""

import difflib
import fnmatch
import os
import pathlib
import shutil
import subprocess
import sys

from common import BadInput, need

HERE = pathlib.Path(__file__).resolve().parent
DESCRIBED = ("rootsift", "orb")
# Keys that are options of `diffsac_prepare pairs`, by the option's name; the others say what is done with it.
OPTIONS = {"sequence": "sequence", "steps": "steps", "every": "every", "pairs_file": "pairs-file",
           "max_keypoints": "max-keypoints", "max_image_size": "max-image-size", "max_pairs": "max-pairs", "min_true_matches": "min-true-matches",
           "max_disagreement_deg": "max-disagreement", "true_share": "true-share", "true_match_px": "true-match-px", "features": "features"}
OTHERS = ("name", "input", "needs", "convert", "format", "output", "scene", "scenes", "described", "focal", "center", "import_descriptors", "thumbnails",
          "warp_images", "warp_views", "warp_tilt", "warp_photograph", "descriptors")


def read_sets(path):
    """Those with descriptors as sets of their own."""
    try:
        import yaml
    except ImportError:
        raise BadInput("there is no module yaml (Debian: python3-yaml)") from None
    try:
        content = yaml.safe_load(pathlib.Path(path).read_text())
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: {' '.join(str(error).split())}") from None
    need(isinstance(content, dict) and isinstance(content.get("sets"), list) and content["sets"], f"{path}: expected sets, a list of image sets")
    sets = []
    for number, one in enumerate(content["sets"], 1):
        place = f"{path}: set {number}"
        need(isinstance(one, dict) and one.get("name"), f"{place}: expected a name")
        place = f"{path}: {one['name']}"
        for key in one:
            near = difflib.get_close_matches(str(key), [*OPTIONS, *OTHERS], 1, 0)
            need(key in OPTIONS or key in OTHERS, f"{place}: there is no key {key}: {near[0]} is the nearest")
        need(isinstance(one.get("input"), list) and one["input"], f"{place}: expected input, a list of folders")
        need(one.get("format") or one.get("convert"), f"{place}: expected a format, or what converts it")
        need(one.get("described") in (None, "test", "train"), f"{place}: described: expected test or train")
        if one.get("output"):
            sets.append(one)
        for features in DESCRIBED if one.get("described") else ():
            sets.append({**one, "name": f"{one['name']}_{features}", "output": f"runs/descriptors/{features}/{one['described']}",
                         "features": features, "descriptors": True})
    return sets


def makes(one, wanted):
    """Whether a set goes by this name, or makes this folder, a folder in it or a folder around it."""
    output = one["output"]
    return (fnmatch.fnmatchcase(one["name"], wanted) or wanted == output or output.startswith(wanted + "/")
            or any(fnmatch.fnmatchcase(wanted, f"{output}/{scene}") for scene in one.get("scenes", [])))


def input_of(one, data):
    """Its folder or file below the folder of data; and what is missing."""
    needs = one.get("needs", "")
    for place in one["input"]:
        path = os.path.normpath(os.path.join(data, place))
        if os.path.isdir(os.path.join(path, needs)) if needs else os.path.exists(path):
            break
    else:
        return "", os.path.normpath(os.path.join(data, one["input"][0], needs))
    features = os.path.join(data, one.get("import_descriptors", ""))
    return path, "" if os.path.exists(features) else features


def run(*words):
    words = [str(word) for word in words]
    done = subprocess.run(words)
    need(done.returncode == 0, f"{words[0]} {words[1]} failed (exit status {done.returncode}): {' '.join(words)}")


def text_of(value):
    return ",".join(map(str, value)) if isinstance(value, list) else value


def converted(one, source):
    """What the converter makes: a COLMAP model in runs/converted, or without a format the scenes themselves."""
    model = "runs/converted/" + (one.get("scene") or os.path.basename(source))
    words = ["--scene", one["scene"]] if one.get("scene") and not one.get("format") else []
    if one.get("center"):
        words += ["--focal", one["focal"], "--center", text_of(one["center"])]
    run(sys.executable, HERE / "convert.py", one["convert"], source, model if one.get("format") else one["output"], *words)
    return model


def warped(program, one, source):
    """A scene for each of its images, seen as planes from other places."""
    folder = "runs/warped/" + one["scene"]
    tilt = one.get("warp_tilt", [0, 65])
    run(program, "warp", "--input", source, "--output", folder, "--images", one["warp_images"], "--views", one.get("warp_views", 5),
        "--least-tilt", tilt[0], "--greatest-tilt", tilt[1], *(["--photograph"] if one.get("warp_photograph") else []))
    return [(str(path), f"{one['scene']}_{path.name}") for path in sorted(pathlib.Path(folder).iterdir()) if path.is_dir()]


def make(program, one, source, arguments):
    if one.get("convert"):
        source = converted(one, source)
    if not one.get("format"):
        return
    words = [word for key, option in OPTIONS.items() if key in one for word in ("--" + option, text_of(one[key]))]
    if not one.get("convert"):
        words += [word for key in ("focal", "center") if key in one for word in ("--" + key, text_of(one[key]))]
    if one.get("import_descriptors"):
        words += ["--import-descriptors", os.path.join(arguments.data, one["import_descriptors"])]
    words += ["--no-thumbnails"] if one.get("thumbnails") is False else []
    words += ["--descriptors"] if one.get("descriptors") else []
    parts = warped(program, one, source) if one.get("warp_images") else [(source, one.get("scene"))]
    for folder, scene in parts:
        run(program, "pairs", "--format", one["format"], "--input", folder, "--output", one["output"], "--threads", arguments.threads,
            *(["--scene", scene] if scene else []), *words)


def sets(arguments):
    program = arguments.program or shutil.which("diffsac_prepare") or "build/release/bin/diffsac_prepare"
    need(os.path.isdir(arguments.data), f"--data {arguments.data}: no such folder")
    wanted = [one for one in read_sets(arguments.config) if not arguments.only or any(makes(one, only) for only in arguments.only)]
    made = 0
    for one in wanted:
        source, missing = input_of(one, arguments.data)
        if missing:
            print(f"left out: {one['name']}, there is no {missing}", file=sys.stderr, flush=True)
            continue
        need(os.path.exists(program), f"{program}: no such program; name it with --program")
        made += 1
        make(program, one, source, arguments)
    need(made or not wanted, f"{arguments.data}: there are none of the sets that are asked for")
    print(f"convert: results are in the folders that {arguments.config} names")
