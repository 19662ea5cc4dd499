# Everything but LibTorch comes from the distribution's packages.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(nlohmann_json REQUIRED)
find_package(TBB REQUIRED)
if(NOT DIFFSAC_LAB)
  return()
endif()

find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(PkgConfig REQUIRED)
# Focal lengths of photographs.
pkg_check_modules(LIBEXIF REQUIRED IMPORTED_TARGET libexif)
# Sizes of cameras' sensors, by name; without it EXIF data that only name the camera give no focal length.
pkg_check_modules(LENSFUN IMPORTED_TARGET lensfun)
# Clouds of points; without it diffsac_register takes matches alone. Its package is compiled for any processor, which Eigen's
# alignment shows.
find_package(Open3D QUIET)
find_package(OpenMP QUIET COMPONENTS CXX)
set(DIFFSAC_HAS_REGISTRATION FALSE)
if(Open3D_FOUND AND OpenMP_CXX_FOUND AND NOT DIFFSAC_NATIVE)
  set(DIFFSAC_HAS_REGISTRATION TRUE)
else()
  message(STATUS "diffsac_register takes no clouds, matches alone: it needs Open3D (libopen3d-dev), OpenMP and no DIFFSAC_NATIVE")
endif()
# Recordings of other people's estimators.
find_package(ZLIB REQUIRED)
# COLMAP's databases.
find_package(SQLite3 REQUIRED)
set(HDF5_PREFER_PARALLEL FALSE)
find_package(HDF5 REQUIRED COMPONENTS CXX)

add_library(diffsac_hdf5 INTERFACE)
target_include_directories(diffsac_hdf5 SYSTEM INTERFACE $<BUILD_INTERFACE:${HDF5_INCLUDE_DIRS}>)
target_link_libraries(diffsac_hdf5 INTERFACE $<BUILD_INTERFACE:${HDF5_CXX_LIBRARIES}>)

include(DiffsacTorch)
