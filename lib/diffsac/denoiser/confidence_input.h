#pragma once

#include <torch/torch.h>

namespace diffsac {

/// [B, κ, N] → [B, κ, N, 1], or [.., 2] with the previous prediction (zeros when there is none yet) behind c_t.
inline torch::Tensor ConfidenceInput(const torch::Tensor& c_t, const torch::Tensor& previous, bool self_conditioning) {
  if (!self_conditioning) return c_t.unsqueeze(-1);
  return torch::stack({c_t, previous.defined() ? previous : torch::zeros_like(c_t)}, -1);
}

/// [B, N] → [B · κ, N]: every copy of a problem has its problem's padding. Undefined stays undefined.
inline torch::Tensor MaskOfCopies(const torch::Tensor& mask, std::int64_t copies) {
  return mask.defined() ? mask.repeat_interleave(copies, 0) : mask;
}

}  // namespace diffsac
