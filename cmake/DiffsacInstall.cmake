# cmake --install and find_package(diffsac).
include(CMakePackageConfigHelpers)

set(DIFFSAC_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/diffsac)

# Targets are diffsac_core in the build and diffsac::core everywhere else.
foreach(_name compiler torch hdf5)
  set_target_properties(diffsac_${_name} PROPERTIES EXPORT_NAME ${_name})
endforeach()
# The library, and the lab on top of it, whose dependencies only its users need.
get_property(_lab GLOBAL PROPERTY DIFFSAC_LIBRARIES)
set(_library diffsac diffsac_compiler)
foreach(_room core geometry consensus problem network estimators)
  list(APPEND _library diffsac_${_room})
  list(REMOVE_ITEM _lab diffsac_${_room})
endforeach()
install(TARGETS ${_library} EXPORT diffsacTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS ${_lab} diffsac_torch diffsac_hdf5 EXPORT diffsacLabTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(_export diffsacTargets diffsacLabTargets)
  install(EXPORT ${_export} NAMESPACE diffsac:: DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR})
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/lib/diffsac DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")

set(DIFFSAC_INSTALL_MODELS ${CMAKE_INSTALL_DATADIR}/diffsac/models)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/diffsacConfig.cmake.in
  ${PROJECT_BINARY_DIR}/diffsacConfig.cmake INSTALL_DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR}
  PATH_VARS DIFFSAC_INSTALL_MODELS)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/diffsacConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/diffsacConfig.cmake ${PROJECT_BINARY_DIR}/diffsacConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/DiffsacFindLibTorch.cmake
  DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR})

# What the programs find beside themselves (core/resources.h): the estimators to use, the rows that they include, and the
# networks of those and of lines and planes. Other networks are of baselines and tables, which a checkout has.
set(_share ${CMAKE_INSTALL_DATADIR}/diffsac)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs/pair ${PROJECT_SOURCE_DIR}/configs/colmap
  DESTINATION ${_share}/configs FILES_MATCHING PATTERN "*.yaml")
install(FILES ${PROJECT_SOURCE_DIR}/configs/rows/consensus.yaml ${PROJECT_SOURCE_DIR}/configs/rows/learned_prosac.yaml
  ${PROJECT_SOURCE_DIR}/configs/rows/shared_focal.yaml
  DESTINATION ${_share}/configs/rows)
foreach(_name essential fundamental homography line plane without_ratio_essential without_ratio_fundamental)
  install(FILES ${PROJECT_SOURCE_DIR}/models/${_name}/model.safetensors DESTINATION ${_share}/models/${_name})
endforeach()

# The programs of the build find theirs in the same way.
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/share/diffsac)
foreach(_name configs models)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${_name} ${PROJECT_BINARY_DIR}/share/diffsac/${_name} SYMBOLIC)
endforeach()
