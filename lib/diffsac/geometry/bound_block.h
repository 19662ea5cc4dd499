#pragma once

namespace diffsac {

/// Squares are summed up in blocks of at most so many (square_bounds.h).
inline constexpr int kBoundBlock = 128;

}  // namespace diffsac
