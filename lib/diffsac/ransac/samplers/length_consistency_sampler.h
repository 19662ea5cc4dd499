#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/geometry/points.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// Sets of three matches of two clouds whose edges are as long in one cloud as in the other, for motions (one match is
/// drawn) and, `scaled`, similarities (two are drawn, whose edge says the scale).
///
/// Of the matches that agree with what was drawn, up to 2048 being looked at, most are wrong, but many more of them are
/// right than of all; of these the one is taken that most others agree with (second-order compatibility: Chen, Sun,
/// Yang and Tao, "SC2-PCR", CVPR 2022), and once more for the third. A draw takes some microseconds and memory linear
/// in N, and succeeds about as often as what was drawn is right. One that no other match agrees with, or less than half
/// as many as with another one before, yields one match three times, which solves to nothing.
class LengthConsistencySampler : public MinimalSampler {
 public:
  /// matches: N × 6, finite. tolerance: by how much two lengths may differ, in the second cloud's unit. quality: as
  /// ProsacSampler's, by which matches are drawn; empty: in random order.
  LengthConsistencySampler(const PointMatrix& matches, double tolerance, bool scaled, std::span<const double> quality,
                           const Rng& rng);
  bool Next(std::span<int> set) override;
  int DrawnPoints(int) const override { return scaled_ ? 2 : 1; }

 private:
  static constexpr int kColumns = 6;
  /// Columns of single precision, of all matches in random order or of some.
  struct Columns {
    std::vector<float> values[kColumns];
    int size() const { return static_cast<int>(values[0].size()); }
    /// Those at these places of `other`.
    void Take(const Columns& other, std::span<const int> places);
  };
  /// A match or, with its other end, an edge that others are compared with.
  struct Reference {
    float at[kColumns];
    float scale;
  };

  Reference ReferenceOf(const Columns& columns, int place, float scale) const;
  /// Puts the places of a part of all columns that agree with all references into listed_ and near_.
  void List(std::span<const Reference> references, int begin, int end);
  /// Of some places in `columns` that `may_be` allows, the one that most others agree with; their number in *agreeing.
  /// −1 where there is none.
  template <class MayBe>
  int MostAgreed(const Columns& columns, float scale, const MayBe& may_be, Rng& rng, int* agreeing);
  int CountAgreeing(const Columns& columns, const Reference& reference);
  /// The third of a set whose first two, places in all_, agree with all of near_; −1 without one.
  int Third(int first, int second, float scale, Rng& rng, int* agreeing);
  bool DrawSet(Rng& rng, int* places);

  bool scaled_;
  float tolerance_ = 0.0F, least_ = 0.0F;  ///< Of two lengths; of an edge.
  Rng rng_;
  std::int64_t draws_ = 0;
  Columns all_;
  std::vector<int> rows_;   ///< The match at each place.
  std::vector<int> order_;  ///< Places, in the order in which they are drawn.
  int most_agreeing_ = 0;   ///< Of all sets so far.
  // What one draw looks at.
  std::vector<int> listed_;
  Columns near_;
  std::vector<float> misfit_;
};

}  // namespace diffsac
