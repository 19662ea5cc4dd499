"""The list of problems of report.html with the pictures of pairs, as report.js reads them."""
import json

import numpy as np

import examples
from examples import none_if_nan

MOST_LINES = 30000
MOST_DETAILS = 2000  # Of more lines only those with a picture have a model in the page.
MOST_IMAGE_BYTES = 8_000_000  # Of the page; photographs are made smaller where there are many.
_MOST_STEPS, _UNKNOWN_PLACE = 32767, -32768  # Of a coordinate in 16 bits; of one that is not finite, or far from the image.


def undetermined_text(translation, task):
    """Of what the matches leave open, why, as diffsac_pair says it. Empty where it is determined."""
    letter, moved = {"homography": "H", "fundamental": "F"}.get(task, "t"), "F" if task == "fundamental" else "t"
    return {"pure_rotation": "t is not determined: the camera only turned",
            "static": f"{moved} is not determined: the images show no motion",
            "plane": f"{letter} is not determined: the matches lie on one plane, or the camera only turned",
            "line": f"{letter} is not determined: the matches lie on one line"}.get(translation, "")


def largest_smallest_and_spread(errors, most):
    """At most so many of these errors' positions: half of them the largest, a quarter the smallest, the rest evenly spread over
    what lies between. Unknown errors count as smallest. Ascending."""
    if len(errors) <= most:
        return np.arange(len(errors))
    order = np.argsort(-np.where(np.isnan(errors), -1.0, errors), kind="stable")
    largest, smallest = most - most // 2, most // 4
    spread = most - largest - smallest
    between = len(errors) - largest - smallest
    middle = [order[largest + i * between // spread] for i in range(spread)]
    return np.sort(np.concatenate([order[:largest], np.array(middle, dtype=int), order[len(order) - smallest:]]))


def details(estimates, i, task):
    """Returns model, noise and pose that a line of the list opens; None without any."""
    model, pose, noise = estimates.model(i), estimates.value("pose", i), float(estimates.value("sigma", i))
    if not len(model) and not np.isfinite(noise):
        return None
    known = [none_if_nan(float(value)) for value in pose]
    told = {"noise": noise if np.isfinite(noise) else None, "model": [float(value) for value in model] or None, "pose": known if known[0] is not None else None}
    text = undetermined_text(estimates.text("degeneracy", i), task)
    return {**told, "undetermined": text} if text else told


def _number(value):
    """Short: there are many of them. JSON has no infinity."""
    return "null" if np.isnan(value) else '"inf"' if np.isinf(value) else f"{value:.4g}"


class _Names(dict):
    """Names by number, each once."""

    def number(self, name):
        return self.setdefault(name, len(self))


class ProblemList:
    def __init__(self, run):
        self.run = run
        results, table = run.results, run.problems.copy()
        table["shown"] = table["error_px" if "threshold_px" in results else "angle_deg"]
        if "misclassified" in table:
            table["shown"] = table["misclassified"].fillna(table["shown"])
        chance = table["log10_nfa"] > 0
        table["status"] = table["status"].str.replace("_", " ")
        table["status"] = table["status"].where(~chance, table["status"] + ", may be chance")
        table["again"] = table.groupby(["c", "m", "id"]).cumcount()  # The names of joined runs occur several times.
        # Conditions one after the other, each as its first method has its problems.
        self.problems = table.sort_values(["c", "m"], kind="stable").drop_duplicates(["c", "id", "again"])[["c", "id", "again", "scene", "points"]]
        self.problems = self.problems.reset_index(drop=True)
        self.problems["problem"] = self.problems.index
        self.table = table.merge(self.problems[["c", "id", "again", "problem"]], how="left")
        self.ranking = self._ranking()
        self.pictures = np.full(len(self.problems), -1)

    def _ranking(self):
        """The row whose errors rank the problems: the reference, or the first that competes."""
        methods = self.run.results["methods"]
        first = [m for m, method in enumerate(methods)
                 if (method["name"] == self.run.results["reference"] if self.run.results["reference"] else method["competes"])]
        return first[0] if first else 0

    def problem_of(self, example):
        found = self.problems[(self.problems["c"] == example.condition) & (self.problems["id"] == example.name)]
        return None if found.empty else int(found.index[0])

    def json(self, estimates):
        """A line for each problem and method, and how many were left out. Each method's largest, smallest and evenly spread
        errors stay of long lists."""
        results, table = self.run.results, self.table
        most_of_cell = max(8, MOST_LINES // max(1, len(self.run.cells)))
        scenes, statuses = _Names(), _Names()
        lines, opened, left_out = [], {}, 0
        for (c, m), cell in table.groupby(["c", "m"], sort=True):
            chosen = largest_smallest_and_spread(cell["shown"].to_numpy(), most_of_cell)
            left_out += len(cell) - len(chosen)
            of_cell = estimates.get((c, m))
            for record in cell.iloc[chosen].to_dict("records"):
                values = [str(record["problem"]), str(m), str(statuses.number(record["status"])), _number(record["shown"])]
                if results["poses"]:
                    values += [_number(record["rotation_deg"]), _number(record["translation_deg"])]
                if results["structures"]:
                    values += [_number(record["recall"]), str(int(record["structures"]))]
                values += [str(int(record["inliers"])), str(int(record["hypotheses"])), _number(record["ms_total"])]
                if of_cell and record["index"] in of_cell.at and (len(table) <= MOST_DETAILS or self.pictures[record["problem"]] >= 0):
                    known = details(of_cell, of_cell.at[record["index"]], results["task"])
                    if known:
                        opened[len(lines)] = known
                lines.append(f"[{','.join(values)}]")
        problems = [[one["id"], scenes.number(one["scene"]), one["c"], one["points"], int(self.pictures[one["problem"]])]
                    for one in self.problems.to_dict("records")]
        facts = {"task": results["task"], "unit": results["unit"], "poses": results["poses"], "structures": results["structures"],
                 "two_view": results["two_view"], "method": self.ranking, "condition_label": results["condition_label"],
                 "methods": [one["label"] or one["name"] for one in results["methods"]],
                 "conditions": [one["label"] or one["name"] for one in results["conditions"]],
                 "scenes": list(scenes), "statuses": list(statuses), "problems": problems, "details": opened}
        text = json.dumps(facts, ensure_ascii=False, separators=(",", ":"))
        return text[:-1] + ',\n"lines":[' + ",\n".join(lines) + "]}", left_out


def point_bytes(points, largest_side):
    """Coordinates as 16-bit integers behind the size of their step, a quarter pixel for images up to 8 191 pixels wide."""
    step = np.float32(max(0.25, largest_side / _MOST_STEPS))
    steps = points / step
    known = np.abs(steps) < _MOST_STEPS  # False for NaN.
    return step.tobytes() + np.where(known, np.sign(steps) * np.floor(np.abs(steps) + 0.5), _UNKNOWN_PLACE).astype("<i2").tobytes()


class _Photographs:
    """Each once, read when all pairs are known."""

    def __init__(self, run):
        self._folders, self._wanted, self._numbers = run.results["figures"]["images"], [], _Names()

    def number(self, example, side):
        if not example.images[side]:
            return -1
        number = self._numbers.number((example.scene, example.images[side]))
        if number == len(self._wanted):
            self._wanted.append((example, side))
        return number

    def add_to(self, page):
        """Those that are there. Returns how many had no room."""
        import io

        # The longest side that lets them all in, at about a byte for 6 pixels.
        longest = int(np.clip(np.sqrt(6.0 * MOST_IMAGE_BYTES / max(1, len(self._wanted))), 240, 640))
        used = 0
        for number, (example, side) in enumerate(self._wanted):
            if used >= MOST_IMAGE_BYTES:
                return len(self._wanted) - number
            image = examples.load_image(self._folders, example, side, longest)
            if image is None:
                continue
            out = io.BytesIO()
            image.save(out, "JPEG", quality=72)
            page.bytes(f"image-{number}", out.getvalue())
            used += len(out.getvalue()) * 4 // 3
        return 0


def add_pair_pictures(page, problem_list, pairs, estimates):
    """The matches of each pair with the inliers of every method that kept them, true inliers, and the photographs where they are
    known. Returns what is to be said of them."""
    run, notes = problem_list.run, []
    photographs, pictures, known_points = _Photographs(run), [], _Names()
    for number in range(len(pairs)):
        example = pairs.at(number)
        problem = problem_list.problem_of(example)
        if problem is None:
            continue
        masks, methods, count = [] if example.inliers is None else [example.inliers], [], len(example.points)
        for m in range(len(run.results["methods"])):
            of_cell = estimates.get((example.condition, m))
            if of_cell and example.index in of_cell.at:
                masks.append(of_cell.mask(of_cell.at[example.index], count))
                methods.append(m)
        (w1, h1), (w2, h2) = example.size(0), example.size(1)
        packed = point_bytes(example.points, max(w1, h1, w2, h2))
        points = known_points.get(packed)
        if points is None:  # Conditions that change no point share them.
            points = known_points.number(packed)
            page.bytes(f"points-{points}", packed)
        at = len(pictures)
        page.bytes(f"masks-{at}", b"".join(np.packbits(mask, bitorder="little").tobytes() for mask in masks))
        pictures.append([points, w1, h1, w2, h2, photographs.number(example, 0), photographs.number(example, 1),
                         0 if example.inliers is None else 1, methods])
        problem_list.pictures[problem] = at
    page.json("pictures", json.dumps(pictures, separators=(",", ":")))
    without_room = photographs.add_to(page)
    if len(pictures) < len(problem_list.problems):
        notes.append(f"{len(pictures)} of {len(problem_list.problems)} pairs have a picture: `examples` says of how many of each condition the points are kept.")
    if without_room:
        notes.append(f"{without_room} photographs had no room: their matches stand on grey.")
    return notes
