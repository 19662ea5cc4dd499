#include "diffsac/ransac/samplers/length_consistency_sampler.h"

#include <algorithm>
#include <cmath>

#include "diffsac/geometry/vector_clones.h"
#include "diffsac/ransac/samplers/prosac_sampler.h"

namespace diffsac {
namespace {

constexpr int kWindow = 2048;     ///< Matches looked at in one draw ...
constexpr int kBlock = 512;       ///< ... so many at a time ...
constexpr int kMostListed = 256;  ///< ... until about so many agree.
constexpr int kMostTried = 16;    ///< Of these.
constexpr int kDrawsOfWindow = 64;

/// How far two lengths are from agreeing: at most 0 where they do.
DIFFSAC_VECTOR_CLONES void Misfits(const float* from, float scale, float tolerance, float least,
                                   const float* const* columns, int begin, int end, float* out) {
  const float *x = columns[0], *y = columns[1], *z = columns[2], *u = columns[3], *v = columns[4], *w = columns[5];
  for (int i = begin; i < end; ++i) {
    const float dx = x[i] - from[0], dy = y[i] - from[1], dz = z[i] - from[2];
    const float du = u[i] - from[3], dv = v[i] - from[4], dw = w[i] - from[5];
    const float first = scale * std::sqrt(dx * dx + dy * dy + dz * dz), second = std::sqrt(du * du + dv * dv + dw * dw);
    const float apart = std::abs(first - second) - tolerance, shorter = least - first;
    out[i - begin] = apart > shorter ? apart : shorter;
  }
}

}  // namespace

void LengthConsistencySampler::Columns::Take(const Columns& other, std::span<const int> places) {
  for (int c = 0; c < kColumns; ++c) {
    values[c].resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) values[c][i] = other.values[c][places[i]];
  }
}

LengthConsistencySampler::LengthConsistencySampler(const PointMatrix& matches, double tolerance, bool scaled,
                                                   std::span<const double> quality, const Rng& rng)
    : scaled_(scaled), rng_(rng) {
  const int count = static_cast<int>(matches.rows());
  rows_ = rng_.Fork("order").Permutation(count);
  const Eigen::RowVectorXd middle = matches.colwise().mean();
  double reach = 0.0;
  for (std::vector<float>& column : all_.values) column.resize(rows_.size());
  // Row by row, each of which is fetched from memory once.
  for (int place = 0; place < count; ++place) {
    for (int c = 0; c < kColumns; ++c) {
      const double value = matches(rows_[place], c) - middle[c];
      all_.values[c][place] = static_cast<float>(value);
      if (c >= 3) reach = std::max(reach, std::abs(value));
    }
  }
  // Single precision is no worse than this.
  constexpr double kRounding = 1e-6, kShortestEdge = 3.0;
  tolerance_ = static_cast<float>(tolerance + kRounding * reach);
  least_ = static_cast<float>(kShortestEdge) * tolerance_;
  misfit_.resize(std::max(kBlock, kMostListed + kBlock));
  order_.resize(rows_.size());
  if (quality.size() == rows_.size()) {
    std::vector<int> place_of(rows_.size());
    for (int place = 0; place < count; ++place) place_of[rows_[place]] = place;
    const std::vector<int> best_first = OrderByQuality(quality);
    for (int k = 0; k < count; ++k) order_[k] = place_of[best_first[k]];
  } else {
    for (int k = 0; k < count; ++k) order_[k] = k;
  }
}

LengthConsistencySampler::Reference LengthConsistencySampler::ReferenceOf(const Columns& columns, int place,
                                                                          float scale) const {
  Reference reference{{}, scale};
  for (int c = 0; c < kColumns; ++c) reference.at[c] = columns.values[c][place];
  return reference;
}

void LengthConsistencySampler::List(std::span<const Reference> references, int begin, int end) {
  listed_.clear();
  const float* columns[kColumns];
  for (int c = 0; c < kColumns; ++c) columns[c] = all_.values[c].data();
  float worst[kBlock];
  for (; begin < end && static_cast<int>(listed_.size()) < kMostListed; begin += kBlock) {
    const int size = std::min(kBlock, end - begin);
    for (std::size_t k = 0; k < references.size(); ++k) {
      float* out = k == 0 ? worst : misfit_.data();
      Misfits(references[k].at, references[k].scale, tolerance_, least_, columns, begin, begin + size, out);
      if (k > 0)
        for (int i = 0; i < size; ++i) worst[i] = std::max(worst[i], misfit_[i]);
    }
    int places[kBlock], found = 0;
    for (int i = 0; i < size; ++i) {
      places[found] = begin + i;
      found += worst[i] <= 0.0F ? 1 : 0;
    }
    listed_.insert(listed_.end(), places, places + found);
  }
  near_.Take(all_, listed_);
}

int LengthConsistencySampler::CountAgreeing(const Columns& columns, const Reference& reference) {
  const float* pointers[kColumns];
  for (int c = 0; c < kColumns; ++c) pointers[c] = columns.values[c].data();
  Misfits(reference.at, reference.scale, tolerance_, least_, pointers, 0, columns.size(), misfit_.data());
  return static_cast<int>(
      std::count_if(misfit_.begin(), misfit_.begin() + columns.size(), [](float misfit) { return misfit <= 0.0F; }));
}

template <class MayBe>
int LengthConsistencySampler::MostAgreed(const Columns& columns, float scale, const MayBe& may_be, Rng& rng,
                                         int* agreeing) {
  int best = -1;
  *agreeing = -1;
  const int size = columns.size(), tried = std::min(size, kMostTried);
  for (int k = 0; k < tried; ++k) {
    const int place = tried == size ? k : static_cast<int>(rng.Below(static_cast<std::uint64_t>(size)));
    if (!may_be(place)) continue;
    const int count = CountAgreeing(columns, ReferenceOf(columns, place, scale));
    if (count <= *agreeing) continue;
    *agreeing = count;
    best = place;
  }
  return best;
}

int LengthConsistencySampler::Third(int first, int second, float scale, Rng& rng, int* agreeing) {
  // Off the line through the first two, in either cloud.
  const auto is_off = [&](int place, int side) {
    float a[3], b[3];
    for (int c = 0; c < 3; ++c) {
      const float from = all_.values[side + c][first];
      a[c] = all_.values[side + c][second] - from;
      b[c] = near_.values[side + c][place] - from;
    }
    const float cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const auto square = [](const float* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
    const float least = 0.5F * (side == 0 ? least_ / scale : least_);
    return square(cross) >= least * least * square(a);
  };
  return MostAgreed(
      near_, scale, [&](int place) { return is_off(place, 0) && is_off(place, 3); }, rng, agreeing);
}

bool LengthConsistencySampler::DrawSet(Rng& rng, int* places) {
  const int count = all_.size(), windows = std::max(1, count / kWindow);
  const auto window = static_cast<int>(draws_ / kDrawsOfWindow % windows);
  const int begin = window * kWindow, end = std::min(count, begin + kWindow);
  const int first = order_[static_cast<std::size_t>(draws_ % count)];
  Reference references[2] = {ReferenceOf(all_, first, 1.0F), {}};
  int second = -1, agreeing = 0;
  if (scaled_) {
    second = static_cast<int>(rng.Below(static_cast<std::uint64_t>(count)));
    const Reference other = ReferenceOf(all_, second, 1.0F);
    const auto length = [&](int side) {
      const float *a = references[0].at + side, *b = other.at + side;
      return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    };
    const float scale = length(3) / length(0);
    if (!(length(3) >= least_) || !std::isfinite(scale)) return false;
    references[0].scale = scale;
    references[1] = {{other.at[0], other.at[1], other.at[2], other.at[3], other.at[4], other.at[5]}, scale};
    List(references, begin, end);
  } else {
    List({references, 1}, begin, end);
    const int chosen = MostAgreed(
        near_, 1.0F, [](int) { return true; }, rng, &agreeing);
    if (chosen < 0 || agreeing == 0) return false;
    second = listed_[chosen];
    // Those that agree with both.
    CountAgreeing(near_, ReferenceOf(near_, chosen, 1.0F));
    int kept = 0;
    for (std::size_t i = 0; i < listed_.size(); ++i)
      if (misfit_[i] <= 0.0F) listed_[kept++] = listed_[i];
    listed_.resize(kept);
    near_.Take(all_, listed_);
  }
  const int third = Third(first, second, references[0].scale, rng, &agreeing);
  if (third < 0 || 2 * agreeing < most_agreeing_) return false;
  most_agreeing_ = std::max(most_agreeing_, agreeing);
  places[0] = first;
  places[1] = second;
  places[2] = listed_[third];
  return true;
}

bool LengthConsistencySampler::Next(std::span<int> set) {
  if (set.size() != 3 || all_.size() < 3) return false;
  Rng rng = DrawRng(rng_, draws_);
  int places[3];
  if (!DrawSet(rng, places)) places[0] = places[1] = places[2] = order_[static_cast<std::size_t>(draws_ % all_.size())];
  ++draws_;
  for (int k = 0; k < 3; ++k) set[k] = rows_[places[k]];
  std::sort(set.begin(), set.end());
  return true;
}

}  // namespace diffsac
