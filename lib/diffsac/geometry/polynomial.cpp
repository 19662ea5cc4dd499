#include "diffsac/geometry/polynomial.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace diffsac {
namespace {

constexpr double kPi = 3.14159265358979323846;

double NewtonOnCubic(const double c[4], double z) {
  for (int i = 0; i < 2; ++i) {
    const double value = ((c[3] * z + c[2]) * z + c[1]) * z + c[0];
    const double slope = (3.0 * c[3] * z + 2.0 * c[2]) * z + c[1];
    const double next = z - value / slope;
    if (!std::isfinite(next)) break;
    const double next_value = ((c[3] * next + c[2]) * next + c[1]) * next + c[0];
    if (!(std::abs(next_value) < std::abs(value))) break;
    z = next;
  }
  return z;
}

int SolveQuadratic(double a, double b, double c, double* roots) {
  if (a == 0.0) {
    if (b == 0.0) return 0;
    roots[0] = -c / b;
    return 1;
  }
  const double discriminant = b * b - 4.0 * a * c;
  if (!(discriminant >= 0.0)) return 0;
  // The form without cancellation; the other root by the product c / a.
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  roots[0] = q / a;
  if (q == 0.0) return 1;
  roots[1] = c / q;
  if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
  return 2;
}

/// The Sturm chain p, p', -rem(p, p'), …, kept as the quotients of its recurrence, so that one evaluation costs about
/// four operations a member: p[i] = (slope[i] z + offset[i]) p[i+1] - p[i+2], each member scaled by a positive number.
class SturmChain {
 public:
  SturmChain(const double* c, int degree) : degree_(degree) {
    double above[11], below[11];
    for (int i = 0; i <= degree; ++i) above[i] = c[i];
    for (int i = 0; i < degree; ++i) below[i] = (i + 1) * c[i + 1];
    Rescale(above, degree);
    Rescale(below, degree - 1);
    for (int step = 0; step + 1 < degree; ++step) {
      const int top = degree - step;  // degree of `above`; `below` has one less
      const double slope = above[top] / below[top - 1];
      const double offset = (above[top - 1] - slope * below[top - 2]) / below[top - 1];
      double rest[11];
      rest[0] = offset * below[0] - above[0];
      for (int i = 1; i <= top - 2; ++i) rest[i] = slope * below[i - 1] + offset * below[i] - above[i];
      const double size = Rescale(rest, top - 2);
      slope_[step] = slope;
      offset_[step] = offset;
      factor_[step] = size;
      std::copy(below, below + top, above);
      std::copy(rest, rest + top - 1, below);
    }
    // The last two members: linear and constant.
    linear_[0] = above[0];
    linear_[1] = above[1];
    constant_ = below[0];
  }

  /// Number of sign changes at z.
  int Changes(double z) const {
    double after = constant_;
    double value = linear_[0] + linear_[1] * z;
    int changes = (value < 0.0) != (after < 0.0) ? 1 : 0;
    for (int i = degree_ - 2; i >= 0; --i) {
      const double before = (slope_[i] * z + offset_[i]) * value - factor_[i] * after;
      changes += (before < 0.0) != (value < 0.0) ? 1 : 0;
      after = value;
      value = before;
    }
    return changes;
  }

 private:
  /// Divides by the largest magnitude, which it returns. A leading coefficient of exactly zero is moved by rounding's
  /// worth, so that every degree is present.
  static double Rescale(double* c, int degree) {
    double size = 0.0;
    for (int i = 0; i <= degree; ++i) size = std::max(size, std::abs(c[i]));
    if (!(size > 0.0)) size = 1.0;
    for (int i = 0; i <= degree; ++i) c[i] /= size;
    if (std::abs(c[degree]) < 1e-30) c[degree] = 1e-30;
    return size;
  }

  int degree_;
  double slope_[10], offset_[10], factor_[10];
  double linear_[2], constant_;
};

/// The whole axis onto (-1, 1), so that halving an interval copes with roots of any size.
double FromUnit(double t) { return t / (1.0 - std::abs(t)); }
double ToUnit(double z) { return z / (1.0 + std::abs(z)); }

struct Value {
  double value;
  double slope;
};

Value Evaluate(const double* c, int degree, double z) {
  Value result{c[degree], 0.0};
  for (int i = degree - 1; i >= 0; --i) {
    result.slope = result.slope * z + result.value;
    result.value = result.value * z + c[i];
  }
  return result;
}

/// The root in [low, high], where the polynomial changes its sign: Newton, and halving where Newton leaves the bracket
/// or its steps do not shrink to half: far from the roots it would creep.
double RootInBracket(const double* c, int degree, double low, double high, bool negative_at_low) {
  const auto middle = [&] { return FromUnit(0.5 * (ToUnit(low) + ToUnit(high))); };
  double z = middle();
  double last_step = high - low;
  for (int i = 0; i < 100; ++i) {
    const Value f = Evaluate(c, degree, z);
    if (f.value == 0.0) return z;
    if ((f.value < 0.0) == negative_at_low) {
      low = z;
    } else {
      high = z;
    }
    double next = z - f.value / f.slope;
    const bool newton = next > low && next < high && std::abs(next - z) <= 0.5 * last_step;
    if (!newton) next = middle();
    last_step = std::abs(next - z);
    // Newton doubles the digits: after a step this small there are no more to gain.
    if (next == z || (newton && last_step <= 1e-9 * std::abs(z))) return next;
    z = next;
  }
  return z;
}

}  // namespace

int SolveCubic(const double c[4], double roots[3]) {
  const double size = std::max({std::abs(c[0]), std::abs(c[1]), std::abs(c[2])});
  if (!std::isfinite(size) || !std::isfinite(c[3])) return 0;
  if (!(std::abs(c[3]) > 1e-14 * size)) return SolveQuadratic(c[2], c[1], c[0], roots);
  const double a = c[2] / c[3], b = c[1] / c[3], d = c[0] / c[3];
  const double q = (a * a - 3.0 * b) / 9.0;
  const double r = ((2.0 * a * a - 9.0 * b) * a + 27.0 * d) / 54.0;
  const double q3 = q * q * q;
  int count = 1;
  if (r * r < q3) {
    const double angle = std::acos(std::clamp(r / std::sqrt(q3), -1.0, 1.0));
    for (int i = 0; i < 3; ++i)
      roots[i] = -2.0 * std::sqrt(q) * std::cos((angle + 2.0 * kPi * (i - 1)) / 3.0) - a / 3.0;
    count = 3;
  } else {
    const double s = -std::copysign(std::cbrt(std::abs(r) + std::sqrt(r * r - q3)), r);
    roots[0] = s + (s == 0.0 ? 0.0 : q / s) - a / 3.0;
  }
  for (int i = 0; i < count; ++i) roots[i] = NewtonOnCubic(c, roots[i]);
  std::sort(roots, roots + count);
  return count;
}

int RealRoots10(const double c[11], double roots[10]) {
  double size = 0.0;
  for (int i = 0; i <= 10; ++i) {
    if (!std::isfinite(c[i])) return 0;
    size = std::max(size, std::abs(c[i]));
  }
  int degree = 10;
  while (degree > 0 && std::abs(c[degree]) <= 1e-18 * size) --degree;
  if (degree < 2) {
    if (degree == 0) return 0;
    roots[0] = -c[0] / c[1];
    return 1;
  }
  double bound = 0.0;
  for (int i = 0; i < degree; ++i) bound = std::max(bound, std::abs(c[i] / c[degree]));
  const double limit = ToUnit(1.0 + bound);
  const SturmChain chain(c, degree);

  struct Interval {
    double low, high;  // in the unit coordinate
    int changes_low, changes_high;
    int depth;
  };
  Interval stack[64];
  int left = 0, count = 0;
  stack[left++] = {-limit, limit, chain.Changes(FromUnit(-limit)), chain.Changes(FromUnit(limit)), 0};
  while (left > 0 && count < degree) {
    const Interval interval = stack[--left];
    const int inside = interval.changes_low - interval.changes_high;
    if (inside <= 0) continue;
    const double middle = 0.5 * (interval.low + interval.high);
    if (inside == 1) {
      const double low = FromUnit(interval.low), high = FromUnit(interval.high);
      const bool negative_at_low = Evaluate(c, degree, low).value < 0.0;
      if (negative_at_low != (Evaluate(c, degree, high).value < 0.0)) {
        roots[count++] = RootInBracket(c, degree, low, high, negative_at_low);
        continue;
      }
    }
    if (interval.depth >= 50) {  // a cluster that rounding cannot separate
      roots[count++] = FromUnit(middle);
      continue;
    }
    const int changes = chain.Changes(FromUnit(middle));
    stack[left++] = {middle, interval.high, changes, interval.changes_high, interval.depth + 1};
    stack[left++] = {interval.low, middle, interval.changes_low, changes, interval.depth + 1};
  }
  return count;
}

}  // namespace diffsac
