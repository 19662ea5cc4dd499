#pragma once

#include <torch/types.h>

#include "diffsac/guidance/diffusion/prediction.h"

namespace diffsac {

/// The training loss of a network that predicts c_0 (the paper's Algorithm 1 and its L_diff), averaged over all
/// elements that `mask` keeps:
///
///   Σ w_i m_i l_i / Σ w_i m_i,  w_i = positive_weight where c0 > 0, else 1.
///
/// `prediction` and `c0` [B, κ, N], labels −1 or +1. `mask` bool (or 0/1), broadcastable to that shape, false where a
/// batch is padded; an undefined tensor keeps all. Masked elements, NaN included, have neither value nor gradient.
/// All masked: 0. 16-bit predictions are computed in float32. Throws Error on unequal shapes and on
/// a weight that is not positive.
torch::Tensor DiffusionLoss(DiffusionLossKind kind, const torch::Tensor& prediction, const torch::Tensor& c0,
                            const torch::Tensor& mask = {}, double positive_weight = 1.0);

/// The confidence in (−1, 1) that logits stand for, 2 sigmoid(x) − 1: the expected label.
torch::Tensor LogitsToConfidence(const torch::Tensor& logits);

}  // namespace diffsac
