# Target `packages`: a .tar.gz, and .debs as Debian divides a library, of everything but the lab: diffsac_train and diffsac_eval run
# with a LibTorch that Debian does not have.
set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "robust estimation of geometric models from points with outliers")
set(CPACK_PACKAGE_CONTACT "The DiffSAC C++ authors")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL library programs docs)

# diffsac_deb(GROUP PACKAGE COMPONENTS ... TEXT ... [SECTION ...] [DEPENDS ...] [RECOMMENDS ...] [OVERRIDES ...]): a package of
# these components, with the files that Debian wants of every one. OVERRIDES: what lintian may say.
function(diffsac_deb group package)
  cmake_parse_arguments(ARG "" "SECTION;DEPENDS;RECOMMENDS;TEXT" "COMPONENTS;OVERRIDES" ${ARGN})
  string(TOUPPER ${group} upper)
  foreach(setting SECTION DEPENDS RECOMMENDS)
    if(ARG_${setting})
      set(CPACK_DEBIAN_${upper}_PACKAGE_${setting} "${ARG_${setting}}" PARENT_SCOPE)
    endif()
  endforeach()
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${ARG_TEXT}" PARENT_SCOPE)
  set(components ${ARG_COMPONENTS} deb_${group})
  foreach(component IN LISTS components)
    string(TOUPPER ${component} name)
    set(CPACK_COMPONENT_${name}_GROUP ${group} PARENT_SCOPE)
  endforeach()
  set(DIFFSAC_DEB_COMPONENTS ${DIFFSAC_DEB_COMPONENTS} ${components} PARENT_SCOPE)

  set(folder ${PROJECT_BINARY_DIR}/deb/${package})
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  file(WRITE ${folder}/changelog "diffsac (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * /usr/share/doc/diffsac/CHANGELOG.md of \
diffsac-tools has what changed.\n\n -- ${CPACK_PACKAGE_CONTACT} <nobody@localhost>  ${date}\n")
  execute_process(COMMAND gzip -9nf ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  # The authors give no address.
  set(overrides "${package}: malformed-contact\n${package}: bogus-mail-host-in-debian-changelog\n")
  foreach(tag IN LISTS ARG_OVERRIDES)
    string(APPEND overrides "${package}: ${tag}\n")
  endforeach()
  file(WRITE ${folder}/overrides ${overrides})
  install(FILES ${folder}/changelog.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT deb_${group} EXCLUDE_FROM_ALL)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} RENAME copyright
    COMPONENT deb_${group} EXCLUDE_FROM_ALL)
  install(FILES ${folder}/overrides DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME ${package}
    COMPONENT deb_${group} EXCLUDE_FROM_ALL)
endfunction()

set(_soname ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
diffsac_deb(shared libdiffsac${_soname} COMPONENTS shared SECTION libs TEXT "The shared library."
  OVERRIDES maintscript-calls-ldconfig)  # CPack writes those scripts.
# For packages of others that link it, and for the loader.
file(WRITE ${PROJECT_BINARY_DIR}/deb/shlibs "libdiffsac ${_soname} libdiffsac${_soname} (>= ${PROJECT_VERSION})\n")
file(WRITE ${PROJECT_BINARY_DIR}/deb/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_SHARED_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/deb/shlibs ${PROJECT_BINARY_DIR}/deb/triggers)
# In /usr/lib, as a prefix has it, rather than in a folder for each processor.
diffsac_deb(dev libdiffsac-dev COMPONENTS library namelink SECTION libdevel OVERRIDES pkg-config-unavailable-for-cross-compilation
  DEPENDS "libdiffsac${_soname} (= ${PROJECT_VERSION}), libeigen3-dev, libtbb-dev"
  TEXT "Headers and an archive, for find_package and pkg-config.")
diffsac_deb(tools diffsac-tools COMPONENTS programs docs
  RECOMMENDS "python3-matplotlib, python3-jinja2, python3-pandas, python3-h5py, python3-yaml, python3-scipy, python3-pil"
  OVERRIDES extra-license-file  # That pages link to.
  TEXT "Programs: motions, matrices and vanishing points of photographs and of files of\nmatches.")
if(DIFFSAC_PYTHON)
  find_package(Python REQUIRED COMPONENTS Interpreter)
  math(EXPR _next "${Python_VERSION_MINOR} + 1")
  diffsac_deb(python python3-diffsac COMPONENTS python_deb SECTION python
    DEPENDS "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${_next}), python3-numpy"
    TEXT "A module of Python with the functions of libdiffsac, with numpy in and out.")
endif()

# A folder around the archive's files and all in one; packages are divided.
file(WRITE ${PROJECT_BINARY_DIR}/CPackGenerators.cmake "if(CPACK_GENERATOR STREQUAL TGZ)
  set(CPACK_COMPONENT_INCLUDE_TOPLEVEL_DIRECTORY ON)
  set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
else()
  set(CPACK_COMPONENTS_ALL ${DIFFSAC_DEB_COMPONENTS})
endif()\n")
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_BINARY_DIR}/CPackGenerators.cmake)
include(CPack)

add_custom_target(packages COMMAND ${CMAKE_CPACK_COMMAND} --config ${PROJECT_BINARY_DIR}/CPackConfig.cmake
  WORKING_DIRECTORY ${PROJECT_BINARY_DIR} COMMENT "Packing" VERBATIM)
if(DIFFSAC_PYTHON)
  add_dependencies(packages diffsac_python_stub)
endif()
add_dependencies(packages
  diffsac_pair_program diffsac_vanish_program diffsac_prepare_program diffsac_static diffsac_shared)
