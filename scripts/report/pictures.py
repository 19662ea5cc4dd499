"""Pictures of a run, from what is in its folder."""
import io
import math
import os

import matplotlib
import matplotlib.ticker

matplotlib.use("agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import files  # noqa: E402
import reliability  # noqa: E402
from examples import evenly_chosen  # noqa: E402

DPI = 100  # Sizes below are in pixels.
# Colours that colour-blind readers can tell apart (Okabe and Ito, "Color universal design", 2008). page.css has the same.
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#555555")
INLIER, WRONG, MISSED, OUTLIER = "#0A9440", "#D81E1E", "#3B8EE0", "#9AA2AB"
ESTIMATE = "#D55E00"
_MARKS = ("o", "s", "^", "v", "D", "p", "P", "x", "*", "<", ">", "h", "d", "+")
_DASHES = ("-", "--", ":", "-.")
MOST_CURVES, MOST_STEPS, MOST_POINTS, MOST_LINES, MESH_LINES = 12, 8, 5000, 100, 9

plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "axes.edgecolor": "#404040", "axes.titlesize": 9.5,
                     "axes.grid": True, "grid.color": "#E0E0E0", "axes.axisbelow": True, "legend.frameon": False,
                     "text.parse_math": False})


def structure_colour(number):
    """Of structure 1 and so on: not the last, grey, which would look like an outlier's."""
    return SERIES[(number - 1) % (len(SERIES) - 1)]


def _figure(width, height, rows=1, columns=1, **options):
    return plt.subplots(rows, columns, figsize=(width / DPI, height / DPI), dpi=DPI, squeeze=False, **options)


def _save(figure, folder, name, tight=True):
    out = io.BytesIO()
    if tight:
        figure.tight_layout(rect=(0, 0, 1, 0.95 if figure._suptitle else 1))
    figure.savefig(out, format="png", metadata={"Software": None})
    plt.close(figure)
    files.write_whole(os.path.join(folder, name + ".png"), out.getvalue())
    return True


def _line_style(kind, number):
    """How a curve is drawn: an estimator, one that is to be seen first (strong), the oracle's ceiling, another reference."""
    if kind == "ceiling":
        return {"color": "black", "linestyle": "--", "linewidth": 1.6}
    if kind == "reference":
        return {"color": "#666666", "linestyle": ":", "linewidth": 1.6}
    return {"color": SERIES[number % len(SERIES)], "linestyle": _DASHES[number // len(SERIES) % len(_DASHES)],
            "marker": _MARKS[number % len(_MARKS)], "markersize": 5, "linewidth": 2.4 if kind == "strong" else 1.5}


def _kind(method):
    if method["type"] == "oracle":
        return "ceiling"
    if not method["competes"]:
        return "reference"
    return "strong" if method["type"] == "diffsac" else "method"


def _accuracy_axes(run, axes, x_label):
    axes.set_xlabel(x_label)
    axes.set_ylabel(run.results["accuracy"]["title"])
    axes.set_ylim(0, 1)


def _logarithmic(axes, name, values):
    """Axis x or y from power of ten to power of ten, with plain numbers."""
    low = math.floor(math.log10(min(values)))
    axes.set(**{name + "scale": "log", name + "lim": (10.0 ** low, 10.0 ** max(low + 1, math.ceil(math.log10(max(values)))))})
    axis = getattr(axes, name + "axis")
    axis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def _key_beside(axes, handles=None):
    axes.legend(*(handles or ()), loc="center left", bbox_to_anchor=(1.01, 0.5), handlelength=3)


# --- Curves and bars ---


def draw_curve(run):
    """The accuracy against the conditions' values, a curve a method; only curves of two points and more."""
    curves = []
    for m, method in enumerate(run.results["methods"]):
        points = [(one["value"], run.accuracy(c, m)) for c, one in enumerate(run.results["conditions"])]
        points = [point for point in points if None not in point]
        if len(points) >= 2:
            curves.append((method, points))
    if not run.results["figures"]["curve"] or not curves:
        return False
    figure, ((axes,),) = _figure(1100, 640)
    for number, (method, points) in enumerate(curves):
        axes.plot(*zip(*points), label=method["label"], **_line_style(_kind(method), number))
    _accuracy_axes(run, axes, run.results["condition_label"])
    axes.set_title(run.title, fontsize=11)
    _key_beside(axes)
    return _save(figure, run.folder, "curve")


def draw_bars(run):
    """The rows of `figures.bars` with their intervals: a cluster a condition; of poses two, rotation and translation."""
    results = run.results
    names = {method["name"]: m for m, method in enumerate(results["methods"])}
    rows = [names[name] for name in results["figures"]["bars"]]
    parts = [(", R", "rotation_ci95"), (", t", "translation_ci95")] if results["poses"] and not results["structures"] \
        else [("", results["accuracy"]["metric"] + "_ci95")]
    clusters = []
    for c, condition in enumerate(results["conditions"]):
        for suffix, key in parts:
            bars = [run.cells.get((c, m), {}).get(key) for m in rows]
            if any(bar and bar["mean"] is not None for bar in bars):
                clusters.append((condition["label"] + suffix, bars))
    if not rows or not clusters:
        return False
    figure, ((axes,),) = _figure(min(1800, max(720, 380 + 22 * len(rows) * len(clusters))), 480)
    width = 1.0 / (len(rows) + 1.5)
    for i, m in enumerate(rows):
        known = [(k + width * (i - (len(rows) - 1) / 2), bars[i]) for k, (_, bars) in enumerate(clusters)
                 if bars[i] and bars[i]["mean"] is not None]
        mean = np.array([bar["mean"] for _, bar in known])
        ends = np.array([[bar["low"], bar["high"]] for _, bar in known], dtype=float).reshape(-1, 2).T
        axes.bar([x for x, _ in known], mean, width, yerr=np.abs(ends - mean), capsize=2, ecolor="#303030", edgecolor="#303030",
                 linewidth=0.6, color=SERIES[i % len(SERIES)], alpha=0.85, hatch="" if i < len(SERIES) else "//",
                 label=results["methods"][m]["label"])
    axes.set_xticks(range(len(clusters)), [label for label, _ in clusters])
    axes.grid(axis="x", visible=False)
    _accuracy_axes(run, axes, results["condition_label"])
    axes.set_title(run.title, fontsize=11)
    _key_beside(axes)
    return _save(figure, run.folder, "bars")


def _panels(run, name, panels, prepare):
    """A panel a condition beside each other, with one key beside them so that it hides no curve. `panels`: the condition
    and its curves (label, kind, colour's number, points); `prepare(axes, condition)`: their axes."""
    panels = [panel for panel in panels if panel[1]]
    if not panels:
        return False
    longest = max(len(curve[0]) for _, curves in panels for curve in curves)
    key = max(260, 80 + 7 * longest)
    width = 80 + 380 * len(panels) + key
    figure, (row,) = _figure(width, 480, 1, len(panels))
    for axes, (condition, curves) in zip(row, panels):
        for label, kind, number, points in curves:
            axes.plot(*zip(*points), label=label, **_line_style(kind, number))
        axes.set_title(run.condition_title(condition))
        prepare(axes, condition)
    richest = max(range(len(panels)), key=lambda i: len(panels[i][1]))
    figure.suptitle(run.title, fontsize=11)
    figure.tight_layout(rect=(0, 0, 1 - key / width, 0.97))
    figure.legend(*row[richest].get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(1 - key / width, 0.88), handlelength=3)
    return _save(figure, run.folder, name, tight=False)


def _draw_cost(run, name, cost, x_label):
    """The accuracy against a cost, a curve a series of budgets, and the ceiling over the whole axis."""
    names = {method["name"]: m for m, method in enumerate(run.results["methods"])}

    def curves_of(condition):
        curves = []
        for series in run.results["figures"]["budget"]:
            points = sorted((run.metric(condition, names[m], cost), run.accuracy(condition, names[m])) for m in series["methods"]
                            if run.metric(condition, names[m], cost) and run.accuracy(condition, names[m]) is not None)
            if points:  # The axis is logarithmic: what cost nothing has no place on it.
                curves.append((series["label"], "method" if curves else "strong", len(curves), points))
        if curves:
            low, high = min(c[3][0][0] for c in curves), max(c[3][-1][0] for c in curves)
            for m, method in enumerate(run.results["methods"]):
                ceiling = run.accuracy(condition, m)
                if method["type"] == "oracle" and ceiling is not None:
                    curves.append((method["label"], "ceiling", len(curves), [(low, ceiling), (high, ceiling)]))
        return curves

    def prepare(axes, _):
        _logarithmic(axes, "x", [x for line in axes.lines for x in line.get_xdata()])
        _accuracy_axes(run, axes, x_label)

    return _panels(run, name, [(c, curves_of(c)) for c in range(len(run.results["conditions"]))], prepare)


def draw_budget(run):
    return _draw_cost(run, "budget", "hypotheses", "hypotheses (models solved or scored)")


def draw_time(run):
    return _draw_cost(run, "time", "ms_total", "milliseconds (median)")


def _shown_rows(run, strata):
    """The rows that a picture of a division has room for, in their order: those that differences name first, then the best of
    the first condition."""
    names = [method["name"] for method in run.results["methods"]]
    rows = [names.index(name) for name in strata["rows"]]
    if len(rows) <= MOST_CURVES:
        return rows
    named = [row for one in run.results["differences"] for row in (one["a"], one["b"])]

    def interest(row):
        accuracy = run.accuracy(0, row)
        return (named.index(names[row]) if names[row] in named else len(named), 1.0 if accuracy is None else -accuracy)

    return sorted(sorted(rows, key=interest)[:MOST_CURVES])


def draw_strata(run, strata):
    """The accuracy within the bins of a division, a curve a row: of up to four conditions."""
    name = "strata_" + strata["by"]
    if not any(count for one in strata["bins"] for count in one["problems"]):
        return False
    position = {cell: i for i, cell in enumerate((c["condition"], c["method"]) for c in run.results["results"])}
    rows = _shown_rows(run, strata)
    panels = []
    for c in evenly_chosen(range(len(run.results["conditions"]))):
        curves = []
        for number, row in enumerate(rows):
            method = run.results["methods"][row]
            at = position.get((run.results["conditions"][c]["name"], method["name"]))
            means = [] if at is None else [one["accuracies"][at]["mean"] for one in strata["bins"]]
            points = [(i, mean) for i, mean in enumerate(means) if mean is not None]
            if points:
                curves.append((method["label"], _kind(method), number, points))
        panels.append((c, curves))

    def prepare(axes, condition):
        _accuracy_axes(run, axes, strata["title"] + ", and problems")
        labels = [f"{one['label']}\n{one['problems'][condition]}" for one in strata["bins"]]
        axes.set_xticks(range(len(labels)), labels, fontsize=7.5)
        axes.set_xlim(-0.3, len(labels) - 0.7)

    return _panels(run, name, panels, prepare)


def draw_reliability(run):
    """What probabilities say against how often it is so: a panel for each of up to four conditions."""
    table = [row for row in reliability.table_of(run) if row[2] == "mean"]
    names = [one["name"] for one in run.results["conditions"]]
    conditions = evenly_chosen([c for c, name in enumerate(names) if any(row[1] == name for row in table)])
    if not conditions:
        return False
    figure, (row,) = _figure(60 + 460 * len(conditions), 600, 1, len(conditions), layout="constrained")
    for axes, condition in zip(row, conditions):
        axes.plot([0, 1], [0, 1], color="#999999", linestyle="--", linewidth=1)
        of_condition = [row for row in table if row[1] == names[condition]]
        for number, method in enumerate(dict.fromkeys(row[0] for row in of_condition)):
            curve = np.array([row[-2:] for row in of_condition if row[0] == method], float)
            axes.plot(*curve.T, marker="o", markersize=3.5, color=SERIES[number % len(SERIES)], label=method)
        axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal", xlabel="probability", ylabel="share of true inliers, mean over scenes")
        axes.set_title(run.condition_title(condition))
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), fontsize=8)
    figure.suptitle("How often a point is an inlier, by its probability\n" + run.title, fontsize=10)
    return _save(figure, run.folder, "reliability", tight=False)


def draw_effects(run):
    """What each level of each factor adds to the accuracy of the first, and by how much it multiplies its milliseconds: a dot
    with its interval a level, a colour for each of up to four conditions."""
    levels, names = [], []
    for factor in run.results["effects"]:
        names.append((len(levels) + len(names), factor["factor"]))
        for i, level in enumerate(factor["levels"]):
            levels.append((len(levels) + len(names), i == 0, level))
    conditions = evenly_chosen(range(len(run.results["conditions"])))
    parts = [("accuracy", 0.0, run.results["accuracy"]["title"] + " minus the first level's"),
             ("milliseconds", 1.0, "milliseconds over the first level's")]
    if not levels or any(all(level[2][part][c] is None for level in levels for c in conditions) for part, _, _ in parts):
        return False
    figure, (row,) = _figure(1000, 170 + 26 * (levels[-1][0] + 1), 1, 2, sharey=True)
    for axes, (part, none, label) in zip(row, parts):
        for i, c in enumerate(conditions):
            known = [(height, first, level[part][c]) for height, first, level in levels if level[part][c] is not None]
            shown = np.array([[height + 0.18 * (i - (len(conditions) - 1) / 2)] +
                              ([none] * 3 if first else [np.nan if effect[k] is None else effect[k] for k in ("mean", "low", "high")])
                              for height, first, effect in known], dtype=float).reshape(-1, 4)
            axes.errorbar(shown[:, 1], shown[:, 0], xerr=np.abs(shown[:, 2:].T - shown[:, 1]), fmt="o", markersize=4, capsize=2,
                          color=SERIES[i % len(SERIES)], label=run.results["conditions"][c]["label"])
        axes.axvline(none, color="#404040", linestyle="--", linewidth=1)
        axes.set_xlabel(label)
    row[1].set_xscale("log")
    for formatter in (row[1].xaxis.set_major_formatter, row[1].xaxis.set_minor_formatter):
        formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    row[0].set_yticks([height for height, _, _ in levels] + [height for height, _ in names],
                      [level["level"] for _, _, level in levels] + [name for _, name in names])
    for tick in row[0].get_yticklabels()[len(levels):]:
        tick.set_fontweight("bold")
    row[0].set_ylim(levels[-1][0] + 0.7, -0.5)
    figure.suptitle(run.title, fontsize=11)
    figure.legend(*row[0].get_legend_handles_labels(), loc="upper right", ncols=2)
    return _save(figure, run.folder, "effects")


def draw_training(folder, metrics, is_loss, measure):
    """Losses on the left axis, lines of different dashes; validations on the right, points of different marks, so that nobody
    needs their colours. `metrics`: the columns of metrics.csv, the iteration first."""
    figure, ((axes,),) = _figure(1100, 640)
    right, shown = axes.twinx(), 0
    right.set_axis_off()
    handles = []
    for column in list(metrics.columns)[1:]:
        loss = is_loss(column)
        of_validation = measure(column)
        values = metrics[[metrics.columns[0], column]].dropna()
        if not (loss or of_validation) or values.empty or (loss and not (values[column] > 0).any()):
            continue
        colour = SERIES[shown % len(SERIES)]
        x, y = values.iloc[:, 0], values[column]
        if loss:
            one = "o" if len(values) == 1 else None  # One point is no line.
            handles += axes.plot(x, y, _DASHES[shown % 4], color=colour, linewidth=1.6, marker=one, label=column + " (left)")
            axes.set_ylabel("loss")
        else:
            handles += right.plot(x, y, ":", color=colour, linewidth=1, marker=_MARKS[shown % 8], label=column + " (right)")
            right.set_axis_on()
            right.grid(False)
            right.set_ylim(0, 1)
            right.set_ylabel("validation " + of_validation)
        shown += 1
    if not handles:
        plt.close(figure)
        return False
    losses = [y for line in axes.lines for y in line.get_ydata() if y > 0]
    if losses:
        _logarithmic(axes, "y", losses)
    else:
        axes.set_yticks([])
    axes.set_title("Training curve")
    axes.set_xlabel("iteration")
    axes.xaxis.set_major_formatter(matplotlib.ticker.EngFormatter(sep=""))
    axes.legend(handles, [handle.get_label() for handle in handles], loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2, handlelength=5)
    return _save(figure, folder, "training_curve")


# --- Fits and reverse steps ---


class Box:
    """The box around the finite points, a little larger."""

    def __init__(self, points):
        finite = points[np.isfinite(points).all(axis=1)]
        self.low, self.high = (finite.min(axis=0), finite.max(axis=0)) if len(finite) else (np.zeros(points.shape[1]), np.ones(points.shape[1]))
        margin = max(1e-9, 0.04 * (self.high - self.low).max())
        self.low, self.high = self.low - margin, self.high + margin

    def set(self, axes, downwards):
        """`downwards`: y as the rows of an image."""
        axes.set_xlim(self.low[0], self.high[0])
        axes.set_ylim(*((self.high[1], self.low[1]) if downwards else (self.low[1], self.high[1])))
        if len(self.low) == 3:
            axes.set_zlim(self.low[2], self.high[2])
            axes.set_box_aspect(self.high - self.low)
            axes.view_init(elev=28, azim=-55)
            for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
                axis.set_pane_color((1, 1, 1, 0))
        else:
            axes.set_aspect("equal", adjustable="box")
        axes.tick_params(labelsize=7)


def _scatter(axes, points, **style):
    points = points[np.isfinite(points).all(axis=1)]
    points = points[:: max(1, len(points) // MOST_POINTS)]
    shade = {"depthshade": False} if points.shape[1] == 3 else {}
    axes.scatter(*points.T, linewidths=0, **shade, **style)


def _line(axes, model, box, **style):
    """A line drawn beyond the box, which clips it."""
    normal, centre = np.array(model[:2]), (box.low + box.high) / 2
    foot = centre - (normal @ centre + model[2]) * normal
    reach = np.linalg.norm(box.high - box.low) * np.array([-normal[1], normal[0]])
    axes.plot(*np.array([foot - reach, foot + reach]).T, **style)


def _mesh(axes, model, points, **style):
    """A plane where its points are, along the axis that it contains best."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return
    normal = np.array(model[:3])
    axis = np.argmin(np.abs(normal))
    u = np.eye(3)[axis] - normal[axis] * normal
    u /= np.linalg.norm(u)
    v, origin = np.cross(normal, u), -model[3] * normal
    a, b = (points - origin) @ u, (points - origin) @ v
    a, b = np.meshgrid(np.linspace(a.min(), a.max(), MESH_LINES), np.linspace(b.min(), b.max(), MESH_LINES))
    places = origin[:, None, None] + u[:, None, None] * a + v[:, None, None] * b
    axes.plot_wireframe(*places, alpha=0.6, **style)


def _number(value):
    return math.nan if value is None else float(value)


def fit_title(run, fit, example):
    error = fit["error"]
    title = (f"{run.results['condition_label']} {run.results['conditions'][fit['condition']]['label']}"
             if len(run.results["conditions"]) > 1 else example.id)
    if error["failed"]:
        return f"{title}: {fit['status']}"
    if error["recall"] is not None:
        return f"{title}: recall {_number(error['recall']):.2f}, error {_number(error['misclassified']):.1f} %"
    structures = fit.get("structures")
    if structures and structures["models"]:
        title += f": {len(structures['models'])} structures"
    elif error["angle_deg"] is not None:
        return f"{title}: error {_number(error['angle_deg']):.2f}°"
    return f"{title}: {sum(fit['inliers'])} of {len(example.points)} inliers"


def _draw_fit(axes, fit, example):
    points, flat = example.points, example.points.shape[1] == 2
    structures = fit.get("structures")
    size = (3 if len(points) > 1000 else 10) if not flat else 12
    if points.shape[1] == 4:
        return _draw_segments(axes, fit, points)
    box = Box(points)
    inliers = np.array(fit["inliers"], dtype=bool) if fit["inliers"] else np.zeros(len(points), dtype=bool)
    is_image = fit["downwards"]
    model_length = points.shape[1] + 1
    if structures and not is_image:
        labels = np.array(structures["labels"])
        _scatter(axes, points[labels == 0], s=size, color=OUTLIER, label="outliers")
        for k, model in enumerate(structures["true_models"] if flat else []):
            _line(axes, model, box, color="black", linestyle="--", linewidth=1.2, label="true lines" if k == 0 else None)
        for k, model in enumerate(structures["models"], 1):
            _scatter(axes, points[labels == k], s=size, color=structure_colour(k))
            style = {"color": structure_colour(k)}
            _line(axes, model, box, linewidth=1.6, **style) if flat else _mesh(axes, model, points[labels == k], linewidth=0.7, **style)
    else:
        _scatter(axes, points[~inliers], s=size, color=OUTLIER, label="outliers")
        _scatter(axes, points[inliers], s=size, color=INLIER, label="inliers")
        if not is_image and len(fit["model"]) == model_length:
            if flat:
                _line(axes, fit["model"], box, color=ESTIMATE, linewidth=1.6, label="estimate")
            else:
                _mesh(axes, fit["model"], points[inliers], color=ESTIMATE, linewidth=0.7, label="estimated plane")
        if not is_image and flat and len(fit["true_model"]) == model_length:
            _line(axes, fit["true_model"], box, color="black", linestyle="--", linewidth=1.2, label="true line")
    box.set(axes, is_image)


def _draw_segments(axes, fit, segments):
    """Line segments of an image in the colour of their vanishing point."""
    from matplotlib.collections import LineCollection

    structures = fit.get("structures")
    labels = np.array(structures["labels"]) if structures else np.array(fit["inliers"] or [0] * len(segments))
    for k in range(0, int(labels.max(initial=0)) + 1):
        ends = segments[labels == k].reshape(-1, 2, 2)
        axes.add_collection(LineCollection(ends, colors=OUTLIER if k == 0 else structure_colour(k), linewidths=1 if k == 0 else 1.8,
                                           label="others" if k == 0 else str(k)))
    Box(segments.reshape(-1, 2)).set(axes, True)


def _draw_clouds(axes, fit, points, moved):
    """The matched points of both clouds, or those of the first after the motion, with a line for each inlier."""
    first, second = points[:, :3], points[:, 3:]
    if moved:
        motion = np.reshape(fit["model"], (3, 4))
        first = first @ motion[:, :3].T + motion[:, 3]
        axes.set_title("after the motion")
    inliers = np.array(fit["inliers"] or [0] * len(points), dtype=bool)
    _scatter(axes, first, s=3, color=SERIES[0], label="first cloud")
    _scatter(axes, second, s=3, color=ESTIMATE, label="second cloud")
    ends = np.stack([first[inliers], second[inliers]], axis=1)
    for i, (start, end) in enumerate(ends[:: max(1, len(ends) // MOST_LINES)]):
        axes.plot(*np.array([start, end]).T, color=INLIER, linewidth=0.7, label=None if i else "inliers")
    Box(np.vstack([first, second])).set(axes, False)


def _draw_all_clouds(run, fits):
    """A row a fit: before and after the motion."""
    figure, grid = _figure(1000, 460 * len(fits.fits) + 50, len(fits.fits), 2, layout="constrained", subplot_kw={"projection": "3d"})
    for row, fit in zip(grid, fits.fits):
        example = fits.example(fit)
        row[0].set_title(fit_title(run, fit, example))
        for moved, axes in enumerate(row):
            if moved and not fit["model"]:
                axes.set_axis_off()
                continue
            _draw_clouds(axes, fit, example.points, moved)
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=3, fontsize=7, handlelength=1.5)
    return figure


def draw_fits(run, fits):
    """The kept fits, a column a condition; of several structures each that is found has a colour."""
    if not fits or not fits.fits or run.results["two_view"]:
        return False
    kept = fits.fits
    title = f"{fits.label}: {run.results['task']} fits{' (partial)' if run.partial else ''}"
    if fits.example(kept[0]).points.shape[1] == 6:
        figure = _draw_all_clouds(run, fits)
        figure.suptitle(title, fontsize=12)
        return _save(figure, run.folder, "fits", tight=False)
    one_condition = len(run.results["conditions"]) == 1
    columns = min(4, len(kept) if one_condition else max(1, len(kept) // fits.qualitative))
    rows = -(-len(kept) // columns)
    # Row by row in the grid: the first problem of every condition, then the second.
    seen, ranks = {}, []
    for fit in kept:
        ranks.append(seen.setdefault(fit["condition"], 0))
        seen[fit["condition"]] += 1
    ordered = [fit for _, fit in sorted(zip(ranks, kept), key=lambda pair: pair[0])]
    solid = fits.example(kept[0]).points.shape[1] == 3
    figure, grid = _figure(380 * columns + 20, 420 * rows + 50, rows, columns, layout="constrained",
                           subplot_kw={"projection": "3d"} if solid else {})
    for axes, fit in zip(grid.flat, ordered):
        example = fits.example(fit)
        axes.set_title(fit_title(run, fit, example))
        if not solid:
            axes.set(**dict(zip(("xlabel", "ylabel"), ("u [px]", "v [px]") if fit["downwards"] else ("x", "y"))))
        _draw_fit(axes, fit, example)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02 if solid else -0.12), ncols=4, fontsize=7, handlelength=1.5)
    for axes in grid.flat[len(ordered):]:
        axes.set_axis_off()
    figure.get_layout_engine().set(rect=(0, 0.03, 1, 0.97))  # Keys below panels of equal axes want more room.
    figure.suptitle(title, fontsize=12)
    return _save(figure, run.folder, "fits", tight=False)


def draw_confidence(run, fits):
    """Points coloured by one copy's confidence, a panel a step, the most confident ones circled."""
    if not fits or not fits.trace:
        return False
    trace = fits.trace
    points = fits.example(trace).points
    values = [np.array([_number(value) for value in step]) for step in trace["confidence"]]
    if not values or len(values) != len(trace["timesteps"]) or any(len(step) != len(points) for step in values):
        return False
    steps = evenly_chosen(range(len(values)), MOST_STEPS)
    columns = len(steps) if len(steps) <= 4 else (len(steps) + 1) // 2
    rows = -(-len(steps) // columns)
    solid = points.shape[1] == 3
    figure, grid = _figure(max(560, 390 * columns + 60), 360 * rows + 90, rows, columns, layout="constrained",
                           subplot_kw={"projection": "3d"} if solid else {})
    for axes, step in zip(grid.flat, steps):
        confidence = values[step]
        known = np.isfinite(confidence)  # Others were left out before decoding.
        order = np.argsort(np.where(known, -confidence, np.inf), kind="stable")
        if not known.all():
            axes.scatter(*points[~known].T, s=14, facecolors="none", edgecolors="#BBBBBB")
        shown = order[: known.sum()][::-1]  # Bright points are drawn last, so that they are not hidden.
        coloured = axes.scatter(*points[shown].T, **({"depthshade": False} if solid else {}), s=18, c=confidence[shown], cmap="viridis", vmin=-1, vmax=1, linewidths=0)
        axes.scatter(*points[order[: trace["set_size"]]].T, s=80, facecolors="none", edgecolors=ESTIMATE, linewidths=1.6)
        axes.set_title(f"step {step + 1} of {len(values)}, t = {trace['timesteps'][step]:.3g}")
        Box(points).set(axes, trace["downwards"])
    for axes in grid.flat[len(steps):]:
        axes.set_axis_off()
    figure.suptitle("Confidence over the reverse steps\n(circled: the minimal set; grey: left out before decoding)", fontsize=10)
    figure.colorbar(coloured, ax=list(grid.flat), ticks=(-1, 0, 1), label="confidence", shrink=0.8, pad=0.02)
    return _save(figure, run.folder, "confidence", tight=False)
