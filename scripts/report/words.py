"""What the headings and columns of tables mean, for somebody who sees them first. Exact definitions are in docs/metrics.md."""

_WORDS = (  # What occurs in a heading or a column; the term; its meaning.
    ("mAA@", "mAA@c",
     "Mean average accuracy, 0 to 1: the share of errors up to c/10, 2c/10, ... c, averaged over these ten. 1: "
     "all are within a tenth of c. @0.5deg: c is half a degree."),
    ("mAA_pose@", "mAA_pose@c",
     "The same of the pose that a person is given, with the sign of t: none, or one without t where the camera moved, is wrong."),
    ("AUC@", "AUC@c", "Area under the curve of the share of errors below a limit, for limits up to c; 0 to 1."),
    ("median error", "median error", "Half of the problems have a smaller error. Without a model it is the worst there is."),
    ("median degrees", "median degrees", "The same for rotation or translation alone."),
    ("max(R, t)", "max(R, t)", "The error of a pose: the larger of its two angles, of rotation and of translation."),
    ("failures", "failures", "Problems without a model or a pose. They count with the worst error."),
    ("number of inliers", "inliers",
     "Points within the inlier threshold of the model. Without a truth that is all that is known."),
    ("all-inlier sets", "all-inlier sets", "Minimal sets, the few points a model is solved from, that hold true inliers alone."),
    ("misclassification", "misclassification",
     "Per cent of the points with a wrong label, the found structures matched to the true ones."),
    ("recall", "recall", "Share of the true structures that were found."),
    ("hypotheses", "hypotheses", "Models solved or scored: what an estimate costs, whatever the machine."),
    ("ms", "ms", "Milliseconds an estimate takes on this machine."),
    ("draws", "draws", "Minimal sets drawn."),
    ("training problems", "training problems",
     "Problems that the network was trained on; of a run of: those of the whole training."),
    ("minus", "A minus B", "The difference on the same problems. In bold: its interval leaves zero out."),
    ("normal x", "normal, d", "The line or plane n · x + d = 0; n has length 1, d is in the unit of the points."),
    ("noise", "noise", "Standard deviation of the inliers' distances, in the unit of the points."),
)


def _occurs(tables, text):
    if text == "ms":
        return any("ms" in table.heading or "ms" in table.columns for table in tables)
    return any(text in name for table in tables for name in [table.heading, *table.columns])


def words_of(tables):
    """Term and meaning of those that occur."""
    words = [(term, meaning) for occurs, term, meaning in _WORDS if _occurs(tables, occurs)]
    rows = [row for table in tables for row in table.rows]
    if any(any(row.intervals) for row in rows):
        words.append(("[0.45, 0.57]", "With other problems of the same kind the value lies there in 95 of 100 cases."))
    if any(any(row.best) for row in rows):
        words.append(("bold", "The best of its column; those that print the same are equal."))
    if any("racle" in row.cells[0] for row in rows):
        words.append(("oracle", "Told which points are inliers: the best that any method can do. It does not compete."))
    if any(row.from_paper for row in rows):
        words.append(("paper", "What the paper reports, measured on its own data."))
    return words
