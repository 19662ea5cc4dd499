#pragma once

namespace diffsac {

/// log10 of the number of models that points without any structure would give with as many inliers, all minimal sets
/// tried: (n − γ) C(n, k) C(k, γ) α^(k−γ), the number of false alarms of Moisan and Stival ("A probabilistic criterion
/// to detect rigid point matches between two images and estimate the fundamental matrix", IJCV 2004). Below 0 the
/// inliers are more than chance gives; above it the points may have nothing in common.
///
/// points: n; inliers: k; minimal_set: γ; share: α, the probability in (0, 1] that a point anywhere is within the
/// threshold of a model. Infinite where k ≤ γ.
double Log10Nfa(int points, int inliers, int minimal_set, double share);

/// log10 of the number of models that points without any structure would give with as many inliers at one threshold
/// that was given, all minimal sets tried: C(n, γ) P(at least k − γ of the n − γ others fit), by the binomial
/// distribution (Desolneux, Moisan and Morel, "Meaningful alignments", IJCV 2000). Same arguments; much sharper than
/// Log10Nfa, which allows the threshold to be chosen by the points. Infinite where k ≤ γ.
double LogChanceModels(int points, int inliers, int minimal_set, double share);

}  // namespace diffsac
