#pragma once

#include <Eigen/Core>
#include <concepts>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"

namespace diffsac {

/// A view of N rows of kColumns numbers in the caller's memory, in any layout. It converts from
///   - a matrix, block or map of double, row- or column-major: a view; nothing is copied, and the memory must outlive
///   it;
///   - a temporary matrix: moved into the view, which shares it with its copies;
///   - any other expression, and numbers that are no double (float, int): evaluated once, then as a temporary matrix;
///   - std::vector or std::span of Eigen::Vector2d and the like: a view;
///   - a pointer with strides, as those of numpy or OpenCV.
/// As Eigen itself, it cannot see that a block is one of a temporary matrix: name that matrix first.
template <int kColumns>
class RowsView {
 public:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, kColumns>;                          ///< What is viewed.
  using Row = Eigen::Matrix<double, kColumns, 1>;                                          ///< One of its rows.
  using Map = Eigen::Map<const Matrix, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;  ///< As Eigen has it.

  RowsView() = default;
  /// Strides count doubles from one row to the next and from one column to the next. owner: keeps the memory alive.
  RowsView(const double* data, Eigen::Index rows, Eigen::Index row_stride = kColumns, Eigen::Index column_stride = 1,
           std::shared_ptr<const void> owner = {})
      : data_(data), rows_(rows), row_stride_(row_stride), column_stride_(column_stride), owner_(std::move(owner)) {}
  /// Throws Error for another number of columns.
  template <class Points>
  requires std::derived_from<std::remove_cvref_t<Points>, Eigen::DenseBase<std::remove_cvref_t<Points>>> RowsView(
      Points&& points) {  // NOLINT(google-explicit-constructor)
    using Given = std::remove_cvref_t<Points>;
    using Scalar = typename Given::Scalar;
    static_assert(Given::ColsAtCompileTime == Eigen::Dynamic || Given::ColsAtCompileTime == kColumns);
    if (points.cols() != kColumns && points.rows() > 0)
      throw Error("points: expected N x " + std::to_string(kColumns) + " numbers, got " +
                  std::to_string(points.rows()) + " x " + std::to_string(points.cols()));
    constexpr bool kDirect = (Given::Flags & Eigen::DirectAccessBit) != 0 && std::is_same_v<Scalar, double>;
    constexpr bool kTemporary =
        std::derived_from<Given, Eigen::PlainObjectBase<Given>> && !std::is_lvalue_reference_v<Points>;
    if constexpr (!kDirect)
      Own(std::make_shared<const Matrix>(points.template cast<double>()));
    else if constexpr (kTemporary)
      Own(std::make_shared<const Given>(std::forward<Points>(points)));
    else
      View(points);
  }
  /// Contiguous points.
  RowsView(std::span<const Row> points)  // NOLINT(google-explicit-constructor)
      : RowsView(points.empty() ? nullptr : points.front().data(), static_cast<Eigen::Index>(points.size())) {}
  /// As the span of all.
  RowsView(const std::vector<Row>& points) : RowsView(std::span(points)) {}  // NOLINT(google-explicit-constructor)

  /// N.
  Eigen::Index rows() const { return rows_; }
  /// Whether there are none.
  bool empty() const { return rows_ == 0; }
  /// The rows as an expression of Eigen.
  Map matrix() const { return Map(data_, rows_, kColumns, {column_stride_, row_stride_}); }

 private:
  template <class Points>
  void View(const Points& points) {
    *this = RowsView(points.data(), points.rows(), points.rowStride(), points.colStride());
  }
  template <class Points>
  void Own(std::shared_ptr<const Points> points) {
    View(*points);
    owner_ = std::move(points);
  }

  const double* data_ = nullptr;
  Eigen::Index rows_ = 0, row_stride_ = kColumns, column_stride_ = 1;
  std::shared_ptr<const void> owner_ = {};  ///< Of what was a temporary.
};

using Points2DView = RowsView<2>;  ///< N × 2: points of an image or in the plane.
using Points3DView = RowsView<3>;  ///< N × 3: points in space.
using SegmentsView = RowsView<4>;  ///< N × 4: x1 y1 x2 y2, the ends of line segments.
using ValuesView = RowsView<1>;    ///< N numbers.

}  // namespace diffsac
