# cmake --install and find_package(diffsac).
include(CMakePackageConfigHelpers)

set(DIFFSAC_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/diffsac)

# Targets are diffsac_core in the build and diffsac::core everywhere else.
get_property(_libraries GLOBAL PROPERTY DIFFSAC_LIBRARIES)
foreach(_name compiler torch hdf5)
  set_target_properties(diffsac_${_name} PROPERTIES EXPORT_NAME ${_name})
endforeach()
install(TARGETS ${_libraries} diffsac_compiler diffsac_torch diffsac_hdf5 EXPORT diffsacTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT diffsacTargets NAMESPACE diffsac:: DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/lib/diffsac DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/diffsacConfig.cmake.in
  ${PROJECT_BINARY_DIR}/diffsacConfig.cmake INSTALL_DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/diffsacConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/diffsacConfig.cmake ${PROJECT_BINARY_DIR}/diffsacConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/DiffsacFindLibTorch.cmake
  DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR})
