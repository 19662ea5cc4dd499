# Finds LibTorch without find_package(Torch): that package probes CUDA in a way CMake 3.25 cannot follow.
# Accepts -DTorch_DIR=<...>/share/cmake/Torch, a libtorch folder, or a Python torch folder; otherwise what
# scripts/setup.sh put under .deps/. Defines the target diffsac::torch.
set(Torch_DIR "" CACHE PATH "LibTorch: its root, or its share/cmake/Torch folder")
set(_candidates)
if(Torch_DIR)
  list(APPEND _candidates ${Torch_DIR} ${Torch_DIR}/../../.. ${Torch_DIR}/torch)
elseif(DEFINED ENV{Torch_DIR})
  list(APPEND _candidates $ENV{Torch_DIR} $ENV{Torch_DIR}/../../.. $ENV{Torch_DIR}/torch)
else()
  list(APPEND _candidates ${CMAKE_CURRENT_SOURCE_DIR}/.deps/torch-2.11.0/torch)
endif()
find_path(DIFFSAC_TORCH_ROOT NAMES include/torch/csrc/api/include/torch/torch.h
  PATHS ${_candidates} NO_DEFAULT_PATH)
if(NOT DIFFSAC_TORCH_ROOT)
  message(FATAL_ERROR "LibTorch not found in: ${_candidates}. Run scripts/setup.sh, or give -DTorch_DIR=<libtorch folder>.")
endif()
get_filename_component(DIFFSAC_TORCH_ROOT ${DIFFSAC_TORCH_ROOT} REALPATH)

file(STRINGS ${DIFFSAC_TORCH_ROOT}/include/torch/headeronly/version.h _version_lines
  REGEX "#define TORCH_VERSION_(MAJOR|MINOR|PATCH) [0-9]+")
set(DIFFSAC_TORCH_VERSION "")
foreach(_line ${_version_lines})
  string(REGEX MATCH "[0-9]+$" _number ${_line})
  list(APPEND DIFFSAC_TORCH_VERSION ${_number})
endforeach()
list(JOIN DIFFSAC_TORCH_VERSION "." DIFFSAC_TORCH_VERSION)
message(STATUS "LibTorch ${DIFFSAC_TORCH_VERSION} in ${DIFFSAC_TORCH_ROOT}")

set(_lib ${DIFFSAC_TORCH_ROOT}/lib)
add_library(diffsac_torch INTERFACE)
add_library(diffsac::torch ALIAS diffsac_torch)
target_include_directories(diffsac_torch SYSTEM INTERFACE
  $<BUILD_INTERFACE:${DIFFSAC_TORCH_ROOT}/include>
  $<BUILD_INTERFACE:${DIFFSAC_TORCH_ROOT}/include/torch/csrc/api/include>)
target_link_libraries(diffsac_torch INTERFACE
  $<BUILD_INTERFACE:${_lib}/libtorch_cpu.so> $<BUILD_INTERFACE:${_lib}/libc10.so> Threads::Threads)

# A build with CUDA is meant where the toolkit's driver library can be loaded: its kernels register themselves
# when libtorch_cuda.so is loaded, so the linker must not drop it although no symbol of it is used.
option(DIFFSAC_CUDA "Link LibTorch's CUDA kernels" OFF)
if(DIFFSAC_CUDA)
  target_link_libraries(diffsac_torch INTERFACE
    $<BUILD_INTERFACE:-Wl,--no-as-needed,${_lib}/libtorch_cuda.so,${_lib}/libc10_cuda.so,${_lib}/libtorch.so,--as-needed>)
endif()

# The wheel's CUDA runtime stands in a sibling folder that the linker must find for libtorch_cpu.so's own needs.
set(DIFFSAC_TORCH_RPATH ${_lib})
file(GLOB _runtime ${DIFFSAC_TORCH_ROOT}/../nvidia/*/lib)
foreach(_folder ${_runtime})
  get_filename_component(_folder ${_folder} REALPATH)
  list(APPEND DIFFSAC_TORCH_RPATH ${_folder})
  target_link_options(diffsac_torch INTERFACE $<BUILD_INTERFACE:-Wl,-rpath-link,${_folder}>)
endforeach()
set(CMAKE_BUILD_RPATH ${DIFFSAC_TORCH_RPATH})
set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR};${DIFFSAC_TORCH_RPATH}")
