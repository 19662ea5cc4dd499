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
