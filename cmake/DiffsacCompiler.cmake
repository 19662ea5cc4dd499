# Compiler settings shared by every target, in one interface library.
add_library(diffsac_compiler INTERFACE)
target_compile_features(diffsac_compiler INTERFACE cxx_std_20)
target_compile_options(diffsac_compiler INTERFACE
  $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wno-unknown-pragmas>)
# As an option rather than CMake's property: programs would get -fPIE, which cannot share a precompiled header with
# libraries' -fPIC.
target_compile_options(diffsac_compiler INTERFACE $<BUILD_INTERFACE:-fPIC>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC bugs 105329 and 105651: false alarms inside std::string's operator+, by whichever of these names inlining gives them.
  target_compile_options(diffsac_compiler INTERFACE
    $<BUILD_INTERFACE:-Wno-restrict> $<BUILD_INTERFACE:-Wno-array-bounds> $<BUILD_INTERFACE:-Wno-stringop-overflow>
    $<BUILD_INTERFACE:-Wno-stringop-overread>)
endif()
if(DIFFSAC_WARNINGS_AS_ERRORS)
  target_compile_options(diffsac_compiler INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(DIFFSAC_NATIVE)
  # Public: Eigen's alignment depends on it, so a consumer must use it as well.
  target_compile_options(diffsac_compiler INTERFACE -march=native)
endif()
# Contraction of a*b+c into one rounding would make results depend on the processor.
target_compile_options(diffsac_compiler INTERFACE $<BUILD_INTERFACE:-ffp-contract=off>)
if(DIFFSAC_SANITIZE)
  target_compile_options(diffsac_compiler INTERFACE
    -fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(diffsac_compiler INTERFACE -fsanitize=address,undefined)
endif()
if(DIFFSAC_SANITIZE_THREADS)
  if(DIFFSAC_SANITIZE)
    message(FATAL_ERROR "DIFFSAC_SANITIZE and DIFFSAC_SANITIZE_THREADS exclude each other")
  endif()
  target_compile_options(diffsac_compiler INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
  target_link_options(diffsac_compiler INTERFACE -fsanitize=thread)
endif()
if(DIFFSAC_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "DIFFSAC_FUZZ needs clang (-DCMAKE_CXX_COMPILER=clang++): libFuzzer is part of it")
  endif()
  # Everything reports its coverage; only the fuzz target takes libFuzzer's main.
  target_compile_options(diffsac_compiler INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(diffsac_compiler INTERFACE -fsanitize=fuzzer-no-link)
endif()

find_program(DIFFSAC_CCACHE ccache)
if(DIFFSAC_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Sloppiness: a precompiled header carries times and macros that ccache would otherwise refuse to cache.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${DIFFSAC_CCACHE})
endif()
