#pragma once

namespace diffsac {

/// Types in their order, to be told apart by their places at run time.
template <class... Types>
struct TypeList {
  static constexpr int kSize = sizeof...(Types);
};

/// Calls `body.template operator()<Type>()` with the type at a place in [0, kSize).
template <class Body, class First, class... Rest>
auto DispatchPlace(int place, TypeList<First, Rest...>, Body&& body) {
  if constexpr (sizeof...(Rest) > 0)
    if (place > 0) return DispatchPlace(place - 1, TypeList<Rest...>(), body);
  return body.template operator()<First>();
}

}  // namespace diffsac
