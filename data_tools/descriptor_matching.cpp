#include "data_tools/image_features.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace diffsac {
namespace {

constexpr Eigen::Index kBlockRows = 256;

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

// Between rows of unit length the nearest has the largest inner product, which a matrix product gives fast.
class InnerProducts {
 public:
  InnerProducts(const DescriptorMatrix& first, const DescriptorMatrix& second) : first_(first), second_(second) {}
  void Block(Eigen::Index start, Eigen::Index rows, DescriptorMatrix* similarity) const {
    similarity->noalias() = first_.middleRows(start, rows) * second_.transpose();
  }

 private:
  const DescriptorMatrix &first_, &second_;
};

using Bits = std::vector<std::uint64_t>;

// Rows of 0 and 1, packed.
struct PackedRows {
  explicit PackedRows(const DescriptorMatrix& rows) : words((static_cast<std::size_t>(rows.cols()) + 63) / 64) {
    bits.assign(static_cast<std::size_t>(rows.rows()) * words, 0);
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      for (Eigen::Index j = 0; j < rows.cols(); ++j)
        if (rows(i, j) != 0.0f)
          bits[static_cast<std::size_t>(i) * words + static_cast<std::size_t>(j) / 64] |= std::uint64_t{1} << (j % 64);
  }
  const std::uint64_t* Row(Eigen::Index i) const { return bits.data() + static_cast<std::size_t>(i) * words; }

  std::size_t words;
  Bits bits;
};

int Hamming(const PackedRows& first, Eigen::Index i, const PackedRows& second, Eigen::Index j) {
  const std::uint64_t *a = first.Row(i), *b = second.Row(j);
  int distance = 0;
  for (std::size_t w = 0; w < first.words; ++w) distance += std::popcount(a[w] ^ b[w]);
  return distance;
}

class NegativeHamming {
 public:
  NegativeHamming(const PackedRows& first, const PackedRows& second, Eigen::Index num_second)
      : first_(first), second_(second), num_second_(num_second) {}
  void Block(Eigen::Index start, Eigen::Index rows, DescriptorMatrix* similarity) const {
    similarity->resize(rows, num_second_);
    for (Eigen::Index r = 0; r < rows; ++r)
      for (Eigen::Index j = 0; j < num_second_; ++j)
        (*similarity)(r, j) = -static_cast<float>(Hamming(first_, start + r, second_, j));
  }

 private:
  const PackedRows &first_, &second_;
  Eigen::Index num_second_;
};

template <class Similarity>
Nearest FindNearest(const Similarity& source, Eigen::Index num_first, Eigen::Index num_second) {
  Nearest nearest{std::vector<TwoNearest>(num_first), std::vector<int>(num_second, -1)};
  std::vector<float> best_of_second(num_second, -std::numeric_limits<float>::infinity());
  DescriptorMatrix similarity;
  for (Eigen::Index start = 0; start < num_first; start += kBlockRows) {
    const Eigen::Index rows = std::min(kBlockRows, num_first - start);
    source.Block(start, rows, &similarity);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const auto i = static_cast<int>(start + r);
      const float* row = similarity.row(r).data();
      for (int j = 0; j < static_cast<int>(num_second); ++j) {
        nearest.of_first[i].See(row[j], j);
        if (row[j] > best_of_second[j]) {
          best_of_second[j] = row[j];
          nearest.of_second[j] = i;
        }
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

Nearest FindNearest(const DescriptorMatrix& first, const DescriptorMatrix& second, DescriptorDistance distance) {
  if (distance == DescriptorDistance::kEuclidean)
    return FindNearest(InnerProducts(first, second), first.rows(), second.rows());
  const PackedRows bits1(first), bits2(second);
  return FindNearest(NegativeHamming(bits1, bits2, second.rows()), first.rows(), second.rows());
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

Eigen::VectorXd MatchRatios(const DescriptorMatrix& first, const DescriptorMatrix& second,
                            const MatchIndices& matches) {
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
