# cmake --install, find_package(diffsac) and pkg-config.
include(CMakePackageConfigHelpers)

set(DIFFSAC_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/diffsac)

# diffsac_install(COMPONENT EXPORT TREE ROOMS ... TARGETS ...): headers and libraries. Targets are diffsac_data in the build and
# diffsac::data everywhere else.
function(diffsac_install component export tree)
  cmake_parse_arguments(ARG "" "" "ROOMS;TARGETS" ${ARGN})
  install(TARGETS ${ARG_TARGETS} EXPORT ${export} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
  install(EXPORT ${export} NAMESPACE diffsac:: DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR} COMPONENT ${component})
  list(TRANSFORM ARG_ROOMS PREPEND ${PROJECT_SOURCE_DIR}/lib/${tree}/)
  install(DIRECTORY ${ARG_ROOMS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${tree} COMPONENT ${component}
    FILES_MATCHING PATTERN "*.h")
endfunction()

# Components: what a user of the library compiles with, docs, the programs that need no LibTorch, and the lab, whose
# dependencies only its users need; shared and namelink, of packages alone, are the shared library.
get_property(_lab GLOBAL PROPERTY DIFFSAC_LIBRARIES)
list(TRANSFORM DIFFSAC_LIBRARY_ROOMS PREPEND diffsac_ OUTPUT_VARIABLE _library)
list(REMOVE_ITEM _lab ${_library})
set_target_properties(diffsac_compiler PROPERTIES EXPORT_NAME compiler)
diffsac_install(library diffsacTargets diffsac
  ROOMS ${DIFFSAC_LIBRARY_ROOMS} TARGETS ${DIFFSAC_INSTALLED_LIBRARY} diffsac_compiler)
file(GLOB _public_headers ${PROJECT_SOURCE_DIR}/lib/diffsac/*.h)
install(FILES ${_public_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/diffsac COMPONENT library)
install(TARGETS diffsac_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT shared NAMELINK_COMPONENT namelink
  EXCLUDE_FROM_ALL)
if(DIFFSAC_LAB)
  set_target_properties(diffsac_libtorch PROPERTIES EXPORT_NAME libtorch)
  set_target_properties(diffsac_hdf5 PROPERTIES EXPORT_NAME hdf5)
  diffsac_install(lab diffsacLabTargets lab ROOMS ${DIFFSAC_LAB_ROOMS} TARGETS ${_lab} diffsac_libtorch diffsac_hdf5)
  # A folder of this machine, which the library's files do not name.
  file(WRITE ${PROJECT_BINARY_DIR}/diffsacLabTorch.cmake
    "set(_diffsac_built_with \"${DIFFSAC_TORCH_ROOT}\")\nset(_diffsac_cuda ${DIFFSAC_CUDA})\n")
  install(FILES ${PROJECT_BINARY_DIR}/diffsacLabTorch.cmake ${PROJECT_SOURCE_DIR}/cmake/DiffsacFindLibTorch.cmake
    DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR} COMPONENT lab)
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/diffsacConfig.cmake.in
  ${PROJECT_BINARY_DIR}/diffsacConfig.cmake INSTALL_DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/diffsacConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/diffsacConfig.cmake ${PROJECT_BINARY_DIR}/diffsacConfigVersion.cmake
  DESTINATION ${DIFFSAC_INSTALL_CMAKEDIR} COMPONENT library)

file(RELATIVE_PATH _prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" _prefix ${_prefix})
file(RELATIVE_PATH _libraries ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_LIBDIR})
file(RELATIVE_PATH _headers ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_INCLUDEDIR})
get_target_property(_options diffsac_compiler INTERFACE_COMPILE_OPTIONS)
string(GENEX_STRIP "${_options}" _options)
list(JOIN _options " " _options)
configure_file(${PROJECT_SOURCE_DIR}/cmake/diffsac.pc.in ${PROJECT_BINARY_DIR}/diffsac.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/diffsac.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library)

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright COMPONENT library)

# What the programs find beside themselves (lab/config/paths.h): configurations, what draws pictures and writes pages.
# Networks of baselines and tables come with the lab; the others are in the library.
set(_share ${CMAKE_INSTALL_DATADIR}/diffsac)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${_share} COMPONENT programs)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/scripts/report DESTINATION ${_share} COMPONENT programs
  PATTERN "__pycache__" EXCLUDE)
file(GLOB _converters ${PROJECT_SOURCE_DIR}/data_tools/*.py)
install(FILES ${_converters} DESTINATION ${_share} COMPONENT programs)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/models DESTINATION ${_share} COMPONENT lab FILES_MATCHING PATTERN "model.safetensors"
  PATTERN "xfeat/*")

# The pages that --help names, in the folders in which they name each other.
set(_pages README.md CHANGELOG.md CONTRIBUTING.md data_tools/README.md benchmarks/README.md models/README.md)
install(FILES README.md CHANGELOG.md CONTRIBUTING.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.jpg" PATTERN recorded EXCLUDE)
foreach(_folder data_tools benchmarks models)
  install(FILES ${_folder}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/${_folder} COMPONENT docs)
endforeach()
# And what else they link to: examples, licences, headers.
file(GLOB_RECURSE _more RELATIVE ${PROJECT_SOURCE_DIR} docs/*.md)
foreach(_page ${_pages} ${_more})
  file(READ ${_page} _text)
  string(REPLACE "](" "<to>" _text "${_text}")  # Lists of CMake have brackets of their own.
  string(REGEX MATCHALL "<to>[^]#: ;)]+[#)]" _links "${_text}")
  get_filename_component(_folder ${_page} DIRECTORY)
  foreach(_link ${_links})
    string(REGEX REPLACE "^<to>|/?[#)]$" "" _link ${_link})
    get_filename_component(_link ./${_folder}/${_link} ABSOLUTE)
    file(RELATIVE_PATH _link ${PROJECT_SOURCE_DIR} ${_link})
    list(APPEND _linked ${_link})
  endforeach()
endforeach()
list(REMOVE_DUPLICATES _linked)
list(FILTER _linked EXCLUDE REGEX "^docs/.*(md|png|jpg)$|^docs/results$|^[^/]*(md|cff)$|^[^/]*/README.md$")
foreach(_link ${_linked})
  get_filename_component(_folder ${_link} DIRECTORY)
  set(_kind FILES)
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/${_link})
    set(_kind DIRECTORY)
  endif()
  install(${_kind} ${_link} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${_folder} COMPONENT docs)
endforeach()

# The programs of the build find theirs in the same way.
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/share/diffsac)
foreach(_name configs models)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${_name} ${PROJECT_BINARY_DIR}/share/diffsac/${_name} SYMBOLIC)
endforeach()
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/scripts/report ${PROJECT_BINARY_DIR}/share/diffsac/report SYMBOLIC)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/data_tools/convert.py ${PROJECT_BINARY_DIR}/share/diffsac/convert.py SYMBOLIC)

# --help as pages of man.
foreach(_entry "pair:programs:the model of two images, or of every pair of photographs"
    "vanish:programs:vanishing points, focal length and horizon of photographs"
    "prepare:programs:correspondence files from images, COLMAP, hloc and public data sets"
    "train:lab:train networks of DiffSAC and other learned methods" "eval:lab:run the methods of a table and write its report")
  string(REGEX MATCH "(.*):(.*):(.*)" _ ${_entry})
  if(TARGET diffsac_${CMAKE_MATCH_1}_program)
    install(CODE "
      find_program(HELP2MAN help2man)
      set(page \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1/diffsac_${CMAKE_MATCH_1}.1\")
      if(HELP2MAN)
        file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1\")
        execute_process(COMMAND \${HELP2MAN} --no-info --name \"${CMAKE_MATCH_3}\" --output \"\${page}\"
          \"$<TARGET_FILE:diffsac_${CMAKE_MATCH_1}_program>\"
          COMMAND_ERROR_IS_FATAL ANY)
        execute_process(COMMAND gzip -9nf \"\${page}\" COMMAND_ERROR_IS_FATAL ANY)
      else()
        message(STATUS \"No man page of diffsac_${CMAKE_MATCH_1}: there is no help2man\")
      endif()" COMPONENT ${CMAKE_MATCH_2})
  endif()
endforeach()
