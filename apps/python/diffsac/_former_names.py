"""Names of version 0.2, which run with a DeprecationWarning. Removed in 0.4."""

from typing import Any, Callable, Dict, Tuple

# Of the module.
NAMES = {
    "Cost": "EstimationStats",
    "Estimates": "MultiModelEstimate",
    "SharedFocalEstimate": "UnknownFocalEstimate",
    "Translation": "Degeneracy",
    **{
        f"estimate_{kind}": f"estimate_multiple_{kind}"
        for kind in ("absolute_poses", "essentials", "fundamentals", "homographies", "lines", "planes", "rigid_motions")
    },
}

# Fields of results, and where they are now.
FIELDS = {
    "noise_scale": "sigma",
    "cost": "stats",
    "log_false_alarms": "diagnostics.log10_nfa",
    "rows_left_out": "diagnostics.num_nonfinite",
    "repeated_rows": "diagnostics.num_duplicates",
    "scores_ignored": "diagnostics.scores_ignored",
    "error_probability": "diagnostics.error_probability",
    "mirrored": "diagnostics.mirrored",
    "share_behind": "diagnostics.cheirality_failure_ratio",
    "translation": "diagnostics.degeneracy",
    "other_pose": "ambiguous_pose",
    "other_motion": "ambiguous_pose",
    "motion": "pose",
    "covariance": "pose_covariance",
    "draws": "iterations",
}

# Keyword arguments, and what their values are now.
KEYWORDS: Dict[str, Tuple[str, Callable[[Any], Any]]] = {
    "ratio": ("snn_ratio", lambda value: value),
    "similarities": ("scale_rotation_changes", lambda value: value),
    "max_residual_px": ("max_residual", lambda value: value or None),
    "max_distance": ("max_residual", lambda value: value or None),
    "use_network": ("guidance", lambda value: "network" if value else "none"),
}
