# Finds LibTorch without find_package(Torch): that package probes CUDA in a way CMake 3.25 cannot follow.
# Accepts -DTorch_DIR=<...>/share/cmake/Torch, a libtorch folder, or a Python torch folder; otherwise what
# scripts/setup.sh linked or put under .deps/. Defines the target diffsac::libtorch.
set(Torch_DIR "" CACHE PATH "LibTorch: its root, or its share/cmake/Torch folder")
include(DiffsacFindLibTorch)
if(Torch_DIR)
  diffsac_find_libtorch(DIFFSAC_TORCH_ROOT ${Torch_DIR})
elseif(DEFINED ENV{Torch_DIR})
  diffsac_find_libtorch(DIFFSAC_TORCH_ROOT $ENV{Torch_DIR})
else()
  diffsac_find_libtorch(DIFFSAC_TORCH_ROOT
    ${CMAKE_CURRENT_SOURCE_DIR}/.deps/libtorch ${CMAKE_CURRENT_SOURCE_DIR}/.deps/torch-2.11.0)
endif()
if(NOT DIFFSAC_TORCH_ROOT)
  message(FATAL_ERROR "LibTorch not found. Run scripts/setup.sh, or give -DTorch_DIR=<libtorch folder>.")
endif()
diffsac_libtorch_version(${DIFFSAC_TORCH_ROOT} DIFFSAC_TORCH_VERSION)
message(STATUS "LibTorch ${DIFFSAC_TORCH_VERSION} in ${DIFFSAC_TORCH_ROOT}")

# A build with CUDA is meant where the toolkit's driver library can be loaded: its kernels register themselves
# when libtorch_cuda.so is loaded, so the linker must not drop it although no symbol of it is used.
option(DIFFSAC_CUDA "Link LibTorch's CUDA kernels" OFF)

# The folder stands in the build's interface alone: an installed diffsac finds LibTorch anew (diffsacConfig.cmake).
add_library(diffsac_libtorch INTERFACE)
add_library(diffsac::libtorch ALIAS diffsac_libtorch)
target_link_libraries(diffsac_libtorch INTERFACE Threads::Threads)
diffsac_libtorch_flags(${DIFFSAC_TORCH_ROOT} ${DIFFSAC_CUDA} _includes _libraries _options)
foreach(_item ${_includes})
  target_include_directories(diffsac_libtorch SYSTEM INTERFACE $<BUILD_INTERFACE:${_item}>)
endforeach()
foreach(_item ${_libraries})
  target_link_libraries(diffsac_libtorch INTERFACE $<BUILD_INTERFACE:${_item}>)
endforeach()
foreach(_item ${_options})
  target_link_options(diffsac_libtorch INTERFACE $<BUILD_INTERFACE:${_item}>)
endforeach()

diffsac_libtorch_folders(${DIFFSAC_TORCH_ROOT} DIFFSAC_TORCH_RPATH)
set(CMAKE_BUILD_RPATH ${DIFFSAC_TORCH_RPATH})
