#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "diffsac/core/stored_options.h"

namespace diffsac {

/// The shape of a SetScorer: the group `network` of `method: structure_chooser`.
struct SetScorerOptions {
  int width = 48;       ///< Channels of an element.
  int heads = 4;        ///< Of attention; divides the width.
  int layers = 3;       ///< Of attention and a point-wise network each.
  int hidden = 96;      ///< Channels within the latter.
  int pair_width = 16;  ///< Channels between the features of two elements and what they add to their attention.
};

/// The group `network` of a checkpoint's configuration. Throws Error naming file and key for what no network has.
SetScorerOptions ReadSetScorerOptions(const StoredOptions& network);

/// A small transformer without positions over the elements of a set (Lee et al., "Set Transformer", ICML 2019): each is
/// scored in view of all others, of features of each two of them, which are added to their attention, and of which
/// elements have been taken already. Equivariant to the order of the elements. Computed by Eigen;
/// lab/torch/set_scorer_module.h is the same in LibTorch, for training.
class SetScorer {
 public:
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Fills the values of the tensor of a name, which has this shape. Throws Error where there is none.
  using ReadTensor =
      std::function<void(const std::string& name, const std::vector<std::int64_t>& shape, std::span<float> values)>;
  /// features, pairs: numbers of columns. Throws as `read` does.
  SetScorer(const SetScorerOptions& options, int features, int pairs, const ReadTensor& read);

  /// One set, prepared for scores with different elements taken.
  class Set {
   public:
    /// values: H × features; pairs: H² × pairs, row i·H + j for what i sees of j. Borrows the scorer.
    Set(const SetScorer& scorer, const Rows& values, const Rows& pairs);
    /// The logit of each element; taken: H values.
    Eigen::VectorXf Score(const std::vector<std::uint8_t>& taken) const;

   private:
    Rows Attend(int layer, const Rows& x) const;

    const SetScorer& scorer_;
    Rows embedded_;
    std::vector<Rows> biases_;  ///< H × H, by layer and head.
  };

 private:
  struct Linear {
    Rows weight;  ///< out × in
    Eigen::RowVectorXf bias;
    Rows operator()(const Rows& x) const;
  };
  struct Norm {
    Eigen::RowVectorXf weight, bias;
    Rows operator()(const Rows& x) const;
  };
  struct Layer {
    Norm before_attention, before_hidden;
    Linear attention, output, hidden, back;
  };

  SetScorerOptions options_;
  Eigen::RowVectorXf taken_;
  Linear input_, pair_hidden_, pair_output_, score_hidden_, score_;
  Norm score_norm_;
  std::vector<Layer> layers_;
};

}  // namespace diffsac
