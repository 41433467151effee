# Headers, libraries, CMake package and pkg-config files, all in the install component "development".

include(CMakePackageConfigHelpers)

set(SSJS_CONFIG_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/ssjs")

foreach(part IN LISTS ssjs_parts)
  install(
    TARGETS ssjs_${part}
    EXPORT ssjs-${part}-targets
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development
    LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development
    FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT development)
  install(EXPORT ssjs-${part}-targets NAMESPACE ssjs:: DESTINATION "${SSJS_CONFIG_DIR}" COMPONENT development)
endforeach()

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/ssjs-config.cmake.in" "${PROJECT_BINARY_DIR}/ssjs-config.cmake" INSTALL_DESTINATION "${SSJS_CONFIG_DIR}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/ssjs-config-version.cmake" COMPATIBILITY SameMajorVersion)
install(
  FILES "${PROJECT_BINARY_DIR}/ssjs-config.cmake" "${PROJECT_BINARY_DIR}/ssjs-config-version.cmake" "${PROJECT_SOURCE_DIR}/cmake/FindCHOLMOD.cmake"
        "${PROJECT_SOURCE_DIR}/cmake/FindOpenCVImgproc.cmake"
  DESTINATION "${SSJS_CONFIG_DIR}"
  COMPONENT development)

file(RELATIVE_PATH SSJS_PC_PREFIX "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
foreach(name ssjs ssjs-online)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in" "${PROJECT_BINARY_DIR}/${name}.pc" @ONLY)
endforeach()
install(FILES "${PROJECT_BINARY_DIR}/ssjs.pc" "${PROJECT_BINARY_DIR}/ssjs-online.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT development)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT development)
