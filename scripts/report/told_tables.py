"""All tables and notes of a run: metrics (metric_tables.py), comparisons, effects of factors, strata, values beside the paper's, learned
methods."""
import metric_tables
from tables import UNKNOWN, Row, Table
from values import certain, fixed, interval_text, known, range_text

EFFECT_NOTE = ("Effects: the first level of a factor with its own mean; of the others the difference from it, or the ratio to it, of the same "
               "problems, averaged over all combinations of the other factors' levels that both have; in bold where the interval leaves 0, or "
               "1, out.")


def interval_row(label, intervals, kind):
    return Row([label] + [interval_text(one, kind) for one in intervals], [False] + [certain(one, kind) for one in intervals])


def has_truth(results):
    return any(known(cell[results["accuracy"]["metric"] + "_ci95"]["mean"]) for cell in results["results"])


def condition_text(results, condition):
    """What stands behind a heading where there are several conditions."""
    conditions = results["conditions"]
    return f", {results['condition_label']} {conditions[condition]['label']}" if len(conditions) > 1 else ""


def labels_of(results):
    return {method["name"]: method["label"] for method in results["methods"]}


def comparison_label(results, pair):
    labels = labels_of(results)
    return f"{labels[pair[0]]} − {labels[pair[1]]}"


def difference_tables(results):
    """Of the accuracy, and of the minimal sets where they are known."""
    accuracy, tables = results["accuracy"]["metric"], []
    metrics = {one["metric"] for one in results["differences"]}
    for metric, title in [(accuracy, accuracy)] + [(name, "the share of minimal sets of one structure") for name in metrics - {accuracy}]:
        values = {(one["a"], one["b"], one["condition"]): one for one in results["differences"] if one["metric"] == metric}
        table = Table(f"differences in {title} with 95 % bootstrap intervals", ["A minus B"] + [one["label"] for one in results["conditions"]])
        table.rows = [interval_row(comparison_label(results, pair), [values.get((*pair, one["name"])) for one in results["conditions"]], "difference")
                      for pair in results["compare"]]
        tables.append(table)
    return tables if results["compare"] and has_truth(results) else []


def effect_table(heading, columns, effects_by_column, part):
    """effects_by_column: the factors, and which of their conditions, a column. The first level of each factor with its own mean, the others
    with what they add to it, or by how much they multiply it."""
    kinds = {"accuracy": ("value", "difference"), "milliseconds": ("ms", "ratio")}[part]
    table = Table(heading, ["factor: level"] + columns)
    for f, factor in enumerate(effects_by_column[0][0]):
        for i, level in enumerate(factor["levels"]):
            values = [factors[f]["levels"][i][part][condition] for factors, condition in effects_by_column]
            table.rows.append(interval_row(f"{factor['factor']}: {level['level']}", values, kinds[i > 0]))
    return table


def effect_tables(results):
    if not results["effects"]:
        return []
    of = ", mean over the other factors' levels, with 95 % bootstrap intervals"
    columns = [one["label"] for one in results["conditions"]]
    effects = [(results["effects"], c) for c in range(len(columns))]
    tables = [effect_table(f"effects on {results['accuracy']['metric']}{of}", columns, effects, "accuracy")] if has_truth(results) else []
    return tables + [effect_table("effects on milliseconds, as ratios" + of, columns, effects, "milliseconds")]


def strata_accuracies(results, strata, condition, heading, columns):
    """A row of results.json's accuracies a method, in bold the best of a bin as it is printed."""
    table, competing = Table(heading, ["method"] + columns), []
    cells = {(cell["condition"], cell["method"]): i for i, cell in enumerate(results["results"])}
    methods = {method["name"]: method for method in results["methods"]}
    for name in strata["rows"]:
        at = cells.get((results["conditions"][condition]["name"], name))
        if at is None:
            continue
        values = [one["accuracies"][at] for one in strata["bins"]]
        texts, ranges = [fixed(value["mean"], 3) for value in values], [range_text(value, 3) for value in values]
        table.rows.append(Row([methods[name]["label"]] + texts, [False] * (len(texts) + 1), [""] + ranges))
        competing.append([value["mean"] if methods[name]["competes"] else None for value in values])
    for i in range(len(columns)) if results["conditions"][condition]["rows_share_problems"] else ():
        table.mark_best(i + 1, [row[i] for row in competing])
    return table


def is_known(strata):
    """Whether any problem is in a bin."""
    return any(any(one["problems"]) for one in strata["bins"])


def strata_tables(results):
    """Of each division and condition, a column a bin: the accuracy (that of scenes has a table of its own), the comparisons, the effects."""
    accuracy, tables = results["accuracy"]["metric"], []
    for strata in results["strata"] if has_truth(results) else ():
        for c in range(len(results["conditions"])) if is_known(strata) else ():
            bins = strata["bins"]
            columns = [f"{one['label']} ({one['problems'][c]})" for one in bins]
            of = f" by {strata['title']} (problems){condition_text(results, c)}"
            if strata["by"] != "scene":
                tables.append(strata_accuracies(results, strata, c, accuracy + of, columns))
            if results["compare"]:
                table = Table(f"differences in {accuracy}{of}", ["A minus B"] + columns)
                table.rows = [interval_row(comparison_label(results, pair), [one["differences"][i][c] for one in bins], "difference")
                              for i, pair in enumerate(results["compare"])]
                tables.append(table)
            if results["effects"]:
                tables.append(effect_table(f"effects on {accuracy}{of}", columns, [(one["effects"], c) for one in bins], "accuracy"))
    return tables


def paper_table(results):
    labels = labels_of(results)
    table = Table("ours beside the paper's, which was measured on other data",
                  ["ours / the paper's row", results["condition_label"], "metric", "paper", "ours", "difference", "n"])
    for one in results["beside_paper"]:
        ours = one["ours"]
        if known(ours["mean"]):
            table.add([f"{labels[one['method']]} / {one['paper_row']}", results["conditions"][one["condition"]]["label"], one["metric"],
                       f"{one['paper']:.3g}", interval_text(ours, "value"), f"{ours['mean'] - one['paper']:+.3f}", str(one["problems"])])
    return table


def learned_table(results):
    """What the networks of learned rows were made by (imported ones: by others)."""
    table = Table("learned rows", ["method", "parameters", "training problems", "of a run of", "began with"])
    for name, facts in results["learned"].items():
        problems = [str(facts[key]) if facts["samples"] > 0 else UNKNOWN for key in ("samples", "run_samples")]
        table.add([labels_of(results)[name], str(facts["parameters"])] + problems + [facts["start"] or UNKNOWN])
    return table


def told_tables(results):
    last = [table for table in (paper_table(results), learned_table(results)) if table.rows]
    return difference_tables(results) + effect_tables(results) + strata_tables(results) + last


def tables_of(run):
    return metric_tables.tables_of(run) + told_tables(run.results)


def missing_combinations(results):
    """The levels that some combinations have no row of (a network that is not there), with how many are left."""
    told, rows = [], 1
    for factor in results["effects"]:
        rows *= len(factor["levels"])
    for factor in results["effects"]:
        whole = rows // len(factor["levels"])
        told += [f"{factor['factor']}: {level['level']} {min(level['combinations'])} of {whole}"
                 for level in factor["levels"] if min(level["combinations"]) < whole]
    return ["Of fewer combinations: " + ", ".join(told) + "."] if told else []


def strata_note(results):
    if not has_truth(results):
        return "Strata are left out: the truth is not known."
    text = ("Strata: bins of a quantity of the problems, from the lower edge on and below the upper one; in a bin every problem weighs the "
            "same, whatever its scene.")
    for strata in results["strata"]:
        unknown = [f"{one['label']} {count}" for one, count in zip(results["conditions"], strata["unknown"]) if count]
        if not is_known(strata):
            text += f" Strata by {strata['title']} are left out: it is known of no problem."
        elif unknown:
            text += f" In no stratum, as their {strata['title']} is unknown: {', '.join(unknown)} problems."
    return text


def chance_note(run):
    """Counts estimates that may be chance, for problems without truth."""
    problems, labels = run.problems, [one["label"] for one in run.results["methods"]]
    unknown = problems["error_px" if run.results["unit"] == "px" else "angle_deg"].isna()
    told = [f"{labels[m]} {chance.sum()} of {len(chance)}"
            for (_, m), chance in ((problems["log10_nfa"] > 0) & unknown).groupby([problems["c"], problems["m"]]) if chance.any()]
    return [f"No more inliers than points of no structure would give: {', '.join(told)}."] if told else []


def metric_notes(run):
    """Notes on the columns of metrics."""
    results = run.results
    note = ("hypotheses: models solved or scored, those of features and local optimisation included; ms: milliseconds a problem; both medians over "
            "all problems.")
    if results["structures"]:
        note += " Misclassification: per cent of points with a wrong label, over all problems; recall: share of the true structures that are found."
    elif any("all_pairs" in cell["metrics"] for cell in results["results"]):
        note += " Medians of errors and AUC are unweighted means over the scenes, failures are sums."
    notes = [note]
    if not all(one["rows_share_problems"] for one in results["conditions"]):
        notes.append("Rows are of different problems (other seeds or options of generated data), so none is marked as the best.")
    notes += chance_note(run)
    if set(results["paper"]) - set(results["paper_of_same_data"]):
        notes.append('Rows marked "paper, other data" are the paper\'s figures; its data is not public.')
    return notes


def told_notes(results):
    notes = []
    if results["compare"]:
        notes.append("Differences: of the mean over scenes, pairs redrawn within their scene, both methods' values together; in bold where the "
                     "interval leaves zero out.")
    if results["effects"]:
        notes += [EFFECT_NOTE] + missing_combinations(results)
    return notes + ([strata_note(results)] if results["strata"] else [])


def notes_of(run):
    return metric_notes(run) + told_notes(run.results)
