# `cmake --install build` gives the library, its headers, the program and a config package:
#   find_package(obscura REQUIRED)
#   target_link_libraries(app PRIVATE obscura::obscura)
include(CMakePackageConfigHelpers)

install(TARGETS obscura EXPORT obscuraTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS obscura_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
foreach(header IN LISTS OBSCURA_HEADERS)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/obscura/${folder})
endforeach()
install(FILES scene/scene.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/obscura)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/obscura)
install(EXPORT obscuraTargets NAMESPACE obscura:: DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/obscuraConfig.cmake.in
  ${PROJECT_BINARY_DIR}/obscuraConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/obscuraConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/obscuraConfig.cmake
  ${PROJECT_BINARY_DIR}/obscuraConfigVersion.cmake DESTINATION ${package_folder})
