#pragma once

namespace diffsac {

/// The version of the library, its programs and packages, "MAJOR.MINOR.PATCH". What it promises: docs/versions.md.
/// CMake, CPack and pip read it from this line.
inline constexpr char kVersion[] = "0.3.0";

}  // namespace diffsac
