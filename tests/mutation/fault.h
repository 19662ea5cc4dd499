// What mutate.py puts in place of operators, constants and statements of a copy of the sources: each does what it
// stands for, but for the one fault whose number DIFFSAC_FAULT holds. So that one build serves all faults. Which of
// them were passed at run time goes to the file that DIFFSAC_FAULTS_PASSED names.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <type_traits>
#include <utility>

namespace diffsac::faults {

class Faults {
 public:
  static constexpr int kMany = 1 << 16;

  Faults() {
    if (const char* number = std::getenv("DIFFSAC_FAULT")) active_ = std::atoi(number);
  }
  ~Faults() {
    const char* path = std::getenv("DIFFSAC_FAULTS_PASSED");
    if (path == nullptr) return;
    std::ofstream file(path);
    for (int fault = 0; fault < kMany; ++fault) {
      if (passed_[fault] != 0) file << fault << '\n';
    }
  }
  bool Active(int fault) {
    __atomic_store_n(&passed_[fault], 1, __ATOMIC_RELAXED);
    return fault == active_;
  }

 private:
  unsigned char passed_[kMany] = {};
  int active_ = -1;
};

inline Faults& TheFaults() {
  static Faults faults;
  return faults;
}

/// Never in a constant expression, which cannot be changed at run time.
template <int kFault>
constexpr bool Active() {
  if (std::is_constant_evaluated()) return false;
  return TheFaults().Active(kFault);
}

template <int kFault, typename T>
constexpr T Pick(T right, T wrong) {
  return Active<kFault>() ? wrong : right;
}

template <int kFault, typename T>
constexpr const T& Min(const T& a, const T& b) {
  return Active<kFault>() ? std::max(a, b) : std::min(a, b);
}

template <int kFault, typename T>
constexpr const T& Max(const T& a, const T& b) {
  return Active<kFault>() ? std::min(a, b) : std::max(a, b);
}

/// `Not<3>{} == x` is !x, and x itself with the fault.
template <int kFault>
struct Not {};

template <int kFault, typename T>
constexpr bool operator==(Not<kFault>, const T& value) {
  return Active<kFault>() ? static_cast<bool>(value) : !static_cast<bool>(value);
}

// `a < LtLe<3>{} < b` is a < b, and a <= b with the fault: of the same precedence, so that nothing needs to be parsed.
// What is no number and no bool (expressions of Eigen) does not compile, and is left as it is.
#define DIFFSAC_FAULT(Name, right, wrong)                             \
  template <int kFault>                                               \
  struct Name {};                                                     \
  template <int kFault, typename A>                                   \
  struct Name##Of {                                                   \
    A&& a;                                                            \
  };                                                                  \
  template <int kFault, typename A>                                   \
  constexpr Name##Of<kFault, A> operator right(A&& a, Name<kFault>) { \
    return {std::forward<A>(a)};                                      \
  }                                                                   \
  template <int kFault, typename A, typename B>                       \
  constexpr auto operator right(Name##Of<kFault, A> of, B&& b) {      \
    using Result = std::remove_cvref_t<decltype(of.a right b)>;       \
    static_assert(std::is_arithmetic_v<Result>, "not a number");      \
    if (Active<kFault>()) return static_cast<Result>(of.a wrong b);   \
    return static_cast<Result>(of.a right b);                         \
  }

DIFFSAC_FAULT(LtLe, <, <=)
DIFFSAC_FAULT(LtGt, <, >)
DIFFSAC_FAULT(LeLt, <=, <)
DIFFSAC_FAULT(GtGe, >, >=)
DIFFSAC_FAULT(GtLt, >, <)
DIFFSAC_FAULT(GeGt, >=, >)
DIFFSAC_FAULT(EqNe, ==, !=)
DIFFSAC_FAULT(NeEq, !=, ==)
DIFFSAC_FAULT(AddSub, +, -)
DIFFSAC_FAULT(SubAdd, -, +)
DIFFSAC_FAULT(MulDiv, *, /)
DIFFSAC_FAULT(DivMul, /, *)
#undef DIFFSAC_FAULT

}  // namespace diffsac::faults
