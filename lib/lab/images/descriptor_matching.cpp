#include "lab/images/image_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/geometry/vector_clones.h"
#include "diffsac/guidance/engine/kernels.h"

namespace diffsac {
namespace {

constexpr Eigen::Index kBlockRows = 256;
// A panel of the second image's rows and what a block of the first one's makes of it stay in the second cache.
constexpr int kPanel = 512, kBlock = 96;
static_assert(kPanel % kKernelLanes == 0);

double SquaredDistance(const DescriptorMatrix& first, int i, const DescriptorMatrix& second, int j) {
  return (first.row(i).cast<double>() - second.row(j).cast<double>()).squaredNorm();
}

// The two most similar rows of the other matrix.
struct TwoNearest {
  float best = -std::numeric_limits<float>::infinity(), next = best;
  int best_index = -1, next_index = -1;

  void See(float similarity, int index) {
    if (similarity > best) {
      next = best;
      next_index = best_index;
      best = similarity;
      best_index = index;
    } else if (similarity > next) {
      next = similarity;
      next_index = index;
    }
  }
};

struct Nearest {
  std::vector<TwoNearest> of_first;
  std::vector<int> of_second;
};

// Between rows of unit length the nearest has the largest inner product, which a matrix product gives fast. Products
// are the network's kernels, for the processor that there is: they round a little differently from one to another.
class InnerProducts {
 public:
  InnerProducts(const DescriptorMatrix& first, const DescriptorMatrix& second)
      : first_(first), second_(second), panel_(second.cols(), kPanel), zeros_(kPanel, 0.0f) {}

  void SetPanel(Eigen::Index start, Eigen::Index columns) {
    panel_.setZero();
    panel_.leftCols(columns) = second_.middleRows(start, columns).transpose();
  }
  void Block(Eigen::Index start, Eigen::Index rows, float* similarity) const {
    kernels_.linear(first_.row(start).data(), static_cast<int>(rows), static_cast<int>(first_.cols()), kPanel,
                    {panel_.data(), zeros_.data()}, similarity);
  }

 private:
  const DescriptorMatrix &first_, &second_;
  DescriptorMatrix panel_;
  std::vector<float> zeros_;
  const Kernels& kernels_ = BestKernels();
};

DIFFSAC_BOUND_CLONES float Largest(const float* values, int count) {
  float largest = values[0];
  for (int j = 1; j < count; ++j) largest = values[j] > largest ? values[j] : largest;
  return largest;
}

/// What row `i` is to the other image's rows: where it is the most similar one so far.
DIFFSAC_BOUND_CLONES void SeeRow(const float* similarity, int count, int i, float* best, int* best_index) {
  for (int j = 0; j < count; ++j) {
    const bool better = similarity[j] > best[j];
    best[j] = better ? similarity[j] : best[j];
    best_index[j] = better ? i : best_index[j];
  }
}

/// The columns from `first` on, a few at a time: most hold nothing that is among the two nearest.
void SeeColumns(const float* similarity, int count, int first, TwoNearest* nearest) {
  constexpr int kFew = 64;
  for (int start = 0; start < count; start += kFew) {
    const int few = std::min(kFew, count - start);
    if (!(Largest(similarity + start, few) > nearest->next)) continue;
    for (int j = start; j < start + few; ++j) nearest->See(similarity[j], first + j);
  }
}

Nearest FindNearest(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  InnerProducts source(first, second);
  const Eigen::Index num_first = first.rows(), num_second = second.rows();
  Nearest nearest{std::vector<TwoNearest>(num_first), std::vector<int>(num_second, -1)};
  std::vector<float> best_of_second(num_second, -std::numeric_limits<float>::infinity());
  std::vector<float> similarity(static_cast<std::size_t>(kBlock) * kPanel);
  for (Eigen::Index column = 0; column < num_second; column += kPanel) {
    const auto columns = static_cast<int>(std::min<Eigen::Index>(kPanel, num_second - column));
    source.SetPanel(column, columns);
    for (Eigen::Index start = 0; start < num_first; start += kBlock) {
      const Eigen::Index rows = std::min<Eigen::Index>(kBlock, num_first - start);
      source.Block(start, rows, similarity.data());
      for (Eigen::Index r = 0; r < rows; ++r) {
        const float* row = similarity.data() + r * kPanel;
        SeeColumns(row, columns, static_cast<int>(column), &nearest.of_first[start + r]);
        SeeRow(row, columns, static_cast<int>(start + r), best_of_second.data() + column,
               nearest.of_second.data() + column);
      }
    }
  }
  return nearest;
}

double Ratio(const DescriptorMatrix& first, int i, const DescriptorMatrix& second, const TwoNearest& nearest,
             DescriptorDistance distance) {
  if (nearest.next_index < 0) return 1.0;
  const double best = SquaredDistance(first, i, second, nearest.best_index);
  const double next = SquaredDistance(first, i, second, nearest.next_index);
  if (!(next > 0.0)) return 1.0;
  // The squared distance of rows of 0 and 1 is Hamming's.
  return std::min(1.0, distance == DescriptorDistance::kHamming ? best / next : std::sqrt(best / next));
}

/// Of 1 and -1 for the bits: the inner product falls by two with each bit that differs, without rounding.
Nearest FindNearest(const DescriptorMatrix& first, const DescriptorMatrix& second, DescriptorDistance distance) {
  if (distance == DescriptorDistance::kEuclidean) return FindNearest(first, second);
  const auto signs = [](const DescriptorMatrix& bits) { return DescriptorMatrix(2.0f * bits.array() - 1.0f); };
  return FindNearest(signs(first), signs(second));
}

}  // namespace

std::vector<DescriptorMatch> MatchMutually(const DescriptorMatrix& first, const DescriptorMatrix& second,
                                           DescriptorDistance distance) {
  std::vector<DescriptorMatch> matches;
  if (first.rows() == 0 || second.rows() == 0) return matches;
  const Nearest nearest = FindNearest(first, second, distance);
  for (int i = 0; i < static_cast<int>(first.rows()); ++i) {
    const TwoNearest& of_first = nearest.of_first[i];
    if (of_first.best_index < 0 || nearest.of_second[of_first.best_index] != i) continue;
    matches.push_back({i, of_first.best_index, Ratio(first, i, second, of_first, distance)});
  }
  return matches;
}

Eigen::VectorXd SnnRatios(const DescriptorMatrix& first, const DescriptorMatrix& second, const MatchIndices& matches) {
  Eigen::VectorXd ratios(matches.rows());
  DescriptorMatrix queries, similarity;
  for (Eigen::Index start = 0; start < matches.rows(); start += kBlockRows) {
    const Eigen::Index rows = std::min(kBlockRows, matches.rows() - start);
    queries.resize(rows, first.cols());
    for (Eigen::Index r = 0; r < rows; ++r) queries.row(r) = first.row(matches(start + r, 0));
    similarity.noalias() = queries * second.transpose();
    for (Eigen::Index r = 0; r < rows; ++r) {
      TwoNearest nearest;
      nearest.best_index = matches(start + r, 1);
      similarity(r, nearest.best_index) = -std::numeric_limits<float>::infinity();
      similarity.row(r).maxCoeff(&nearest.next_index);
      if (second.rows() < 2) nearest.next_index = -1;
      ratios[start + r] = Ratio(first, matches(start + r, 0), second, nearest, DescriptorDistance::kEuclidean);
    }
  }
  return ratios;
}

}  // namespace diffsac
