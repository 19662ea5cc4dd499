# The library, which needs Eigen and TBB alone, and the lab on top of it, of which what stands before torch does without
# LibTorch.
set(DIFFSAC_LIBRARY_ROOMS core geometry ransac problem guidance estimate)
set(DIFFSAC_INSTALLED_LIBRARY diffsac_static)
if(BUILD_SHARED_LIBS)
  set(DIFFSAC_INSTALLED_LIBRARY diffsac_shared)
endif()
set(DIFFSAC_LAB_ROOMS)
if(DIFFSAC_LAB)
  set(DIFFSAC_LAB_ROOMS options ground_truth files config colmap data baselines eval images torch train)
endif()

# diffsac_sources(OUT [EXCEPT ...]): every .cpp of the folder and of those in it but these. Looked up at each build, so that a new file
# needs no entry anywhere.
function(diffsac_sources out)
  cmake_parse_arguments(ARG "" "" "EXCEPT" ${ARGN})
  file(GLOB sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS *.cpp */*.cpp)
  list(REMOVE_ITEM sources "" ${ARG_EXCEPT})
  set(${out} ${sources} PARENT_SCOPE)
endfunction()

# diffsac_library(NAME [EXCEPT ...] [SOURCES ...] DEPENDS ... [PRIVATE ...] [TORCH] [UNITY] [REGISTERS])
# One library a folder: target diffsac_NAME, alias diffsac::NAME, of every .cpp of the folder (diffsac_sources) and of
# what SOURCES adds. TORCH precompiles torch/torch.h. UNITY compiles eight files at a time, which takes little more than
# one of them where LibTorch's templates are most of the work. REGISTERS is for libraries whose files register what they
# define (core/registry.h): the linker takes all of these files, not only those that are called by name.
function(diffsac_library name)
  cmake_parse_arguments(ARG "TORCH;UNITY;REGISTERS" "" "EXCEPT;SOURCES;DEPENDS;PRIVATE" ${ARGN})
  diffsac_sources(sources EXCEPT ${ARG_EXCEPT})
  set(library diffsac_${name})
  if(ARG_REGISTERS)
    # Whoever links diffsac_NAME links the whole of this one, here as with an installed diffsac.
    set(library diffsac_${name}_archive)
    add_library(diffsac_${name} INTERFACE)
    target_link_libraries(diffsac_${name} INTERFACE $<LINK_LIBRARY:WHOLE_ARCHIVE,diffsac::${name}_archive>)
  endif()
  add_library(${library} STATIC ${sources} ${ARG_SOURCES})
  if(ARG_REGISTERS)
    add_library(diffsac::${name}_archive ALIAS ${library})
    set_target_properties(${library} PROPERTIES OUTPUT_NAME diffsac_${name} EXPORT_NAME ${name}_archive)
    set_property(GLOBAL APPEND PROPERTY DIFFSAC_LIBRARIES ${library})
  endif()
  add_library(diffsac::${name} ALIAS diffsac_${name})
  set_target_properties(diffsac_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${library} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/lib> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  # An installed lab stands on the one library that the library's rooms are then (lib/diffsac/CMakeLists.txt).
  list(JOIN DIFFSAC_LIBRARY_ROOMS "|" rooms)
  foreach(list ARG_DEPENDS ARG_PRIVATE)
    list(TRANSFORM ${list} REPLACE "^diffsac_(${rooms})$" "$<BUILD_INTERFACE:diffsac_\\1>;$<INSTALL_INTERFACE:${DIFFSAC_INSTALLED_LIBRARY}>")
  endforeach()
  target_link_libraries(${library} PUBLIC diffsac_compiler ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
  set_property(GLOBAL APPEND PROPERTY DIFFSAC_LIBRARIES diffsac_${name})
  if(ARG_TORCH)
    diffsac_use_torch(${library})
  endif()
  # Who installs by pip compiles everything, once. core has no Eigen, files of network have flags of their own.
  if(DIFFSAC_PYTHON AND NOT name MATCHES "^(core|guidance)$")
    target_precompile_headers(${library} PRIVATE <Eigen/Dense> <algorithm> <functional> <memory> <optional> <string> <vector>)
  endif()
  if(ARG_UNITY)
    set_target_properties(${library} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()

# For what computes nothing that counts. At -O1 gcc 14 also drops stores that are read: a test of the five-point solver failed by it.
set(DIFFSAC_QUICK $<$<CONFIG:Release>:-O1>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 14)
  list(APPEND DIFFSAC_QUICK $<$<CONFIG:Release>:-fno-ipa-modref>)
endif()

# diffsac_use_pch(TARGET NAME LINKS ... HEADERS ...): the target shares the precompiled headers NAME, which are made once.
function(diffsac_use_pch target name)
  cmake_parse_arguments(ARG "" "" "LINKS;HEADERS" ${ARGN})
  if(NOT TARGET diffsac_${name}_pch)
    file(WRITE ${CMAKE_BINARY_DIR}/${name}_pch.cpp "// Holds the precompiled headers.\n")
    add_library(diffsac_${name}_pch OBJECT ${CMAKE_BINARY_DIR}/${name}_pch.cpp)
    target_link_libraries(diffsac_${name}_pch PRIVATE diffsac_compiler ${ARG_LINKS})
    target_compile_options(diffsac_${name}_pch PRIVATE ${DIFFSAC_QUICK})
    target_precompile_headers(diffsac_${name}_pch PRIVATE ${ARG_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM diffsac_${name}_pch)
endfunction()

# Links LibTorch and reuses one precompiled torch/torch.h: parsing it costs about 40 s a file.
function(diffsac_use_torch target)
  target_link_libraries(${target} PUBLIC diffsac_libtorch)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${DIFFSAC_TORCH_RPATH}")
  # These files hand their work to LibTorch or to libraries compiled at -O3: -O1 builds them a quarter faster.
  target_compile_options(${target} PRIVATE ${DIFFSAC_QUICK})
  diffsac_use_pch(${target} torch LINKS diffsac_libtorch HEADERS <torch/torch.h>)
endfunction()

# Parsing Catch2 and Eigen costs a file of tests some seconds. Those with LibTorch have its precompiled header instead.
function(diffsac_use_catch target)
  diffsac_use_pch(${target} catch LINKS diffsac_catch Eigen3::Eigen
    HEADERS <catch2/catch.hpp> <Eigen/Dense> <string> <vector> <map> <functional>)
endfunction()

# diffsac_needs_lab(OUT FILE): whether a file of tests includes the lab, or what only the lab needs, itself or by a header
# of the tests.
function(diffsac_needs_lab out file)
  set(${out} FALSE PARENT_SCOPE)
  file(STRINGS ${file} includes REGEX "^#include")
  foreach(line IN LISTS includes)
    string(REGEX REPLACE "^#include [<\"](.*)[>\"].*" "\\1" header "${line}")
    set(needs FALSE)
    if(header MATCHES "^(lab/|torch/|opencv2/|H5)")
      set(needs TRUE)
    elseif(EXISTS ${CMAKE_SOURCE_DIR}/tests/${header})
      diffsac_needs_lab(needs ${CMAKE_SOURCE_DIR}/tests/${header})
    endif()
    if(needs)
      set(${out} TRUE PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()

# diffsac_test(NAME [EXCEPT ...] [SOURCES ...] DEPENDS ... [LAB ...] [TORCH]): one Catch2 program a folder of tests. LAB: what
# those of its files need that compare the library with the lab; without it they are left out.
function(diffsac_test name)
  cmake_parse_arguments(ARG "TORCH" "" "EXCEPT;SOURCES;DEPENDS;LAB" ${ARGN})
  diffsac_sources(sources EXCEPT ${ARG_EXCEPT})
  if(DIFFSAC_LAB)
    list(APPEND ARG_DEPENDS ${ARG_LAB})
  else()
    set(ARG_TORCH FALSE)
    foreach(source IN LISTS sources)
      diffsac_needs_lab(needs ${CMAKE_CURRENT_SOURCE_DIR}/${source})
      if(needs)
        list(REMOVE_ITEM sources ${source})
      endif()
    endforeach()
  endif()
  add_executable(${name}_test ${sources} ${ARG_SOURCES})
  target_link_libraries(${name}_test PRIVATE diffsac_catch_main diffsac_compiler ${ARG_DEPENDS})
  target_include_directories(${name}_test PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  # What is tested is compiled at -O3 in its library; the tests themselves build a fifth faster at -O1.
  target_compile_options(${name}_test PRIVATE ${DIFFSAC_QUICK})
  if(ARG_TORCH)
    diffsac_use_torch(${name}_test)
  else()
    diffsac_use_catch(${name}_test)
  endif()
  # No SKIP_RETURN_CODE: Catch2 exits with the number of failed checks, and four of them are no skipped test.
  # A name that Catch2 2 does not find again, by a semicolon or a bracket that closes nothing, is no test that passed. Catch2 3 fails by itself.
  if(Catch2_VERSION VERSION_LESS 3)
    set(_warned EXTRA_ARGS --warn NoTests)
  endif()
  catch_discover_tests(${name}_test TEST_PREFIX "${name}: " DISCOVERY_MODE PRE_TEST ${_warned}
    PROPERTIES TIMEOUT 240)
endfunction()

# diffsac_use_opencv(TARGET PRIVATE|PUBLIC MODULE...). Debian ships the package file of find_package only with all of OpenCV's
# modules, so those that are needed are looked up one by one.
function(diffsac_use_opencv target visibility)
  if(TARGET ${target}_archive)
    set(target ${target}_archive)
  endif()
  find_path(DIFFSAC_OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
  target_include_directories(${target} SYSTEM ${visibility} ${DIFFSAC_OPENCV_INCLUDE})
  foreach(_module IN LISTS ARGN)
    find_library(DIFFSAC_OPENCV_${_module} opencv_${_module} REQUIRED)
    target_link_libraries(${target} ${visibility} ${DIFFSAC_OPENCV_${_module}})
  endforeach()
endfunction()
