# `cmake --install`: the tool, the C interface as a library, and the files that locate them (CMake package, pkg-config).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(ticktrue_package ${CMAKE_INSTALL_LIBDIR}/cmake/ticktrue)

target_include_directories(ticktrue_c INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set_target_properties(ticktrue PROPERTIES EXPORT_NAME tool)
if(TARGET ticktrue_c_static)
  target_include_directories(ticktrue_c_static INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(TARGETS ticktrue_c_static EXPORT ticktrue-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
endif()

install(TARGETS ticktrue_c EXPORT ticktrue-targets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sdk
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
if(WIN32)
  install(FILES ${CMAKE_BINARY_DIR}/ticktrue.def DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
  install(FILES ${CMAKE_BINARY_DIR}/ticktrue.lib DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk OPTIONAL)
endif()
if(TARGET ticktrue_shim)
  install(TARGETS ticktrue_shim LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
endif()
if(TARGET ticktrue_box2d3)
  install(TARGETS ticktrue_box2d3 RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT box2d3)
endif()
install(TARGETS ticktrue EXPORT ticktrue-targets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sdk)
install(FILES ${PROJECT_SOURCE_DIR}/include/ticktrue.h ${PROJECT_SOURCE_DIR}/include/ticktrue.hpp
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT sdk)
install(FILES ${PROJECT_SOURCE_DIR}/include/ticktrue/math.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ticktrue COMPONENT sdk)
install(EXPORT ticktrue-targets NAMESPACE ticktrue:: DESTINATION ${ticktrue_package} COMPONENT sdk)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/ticktrue-config.cmake.in
  ${CMAKE_BINARY_DIR}/package/ticktrue-config.cmake INSTALL_DESTINATION ${ticktrue_package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/ticktrue-config-version.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/ticktrue-config.cmake ${CMAKE_BINARY_DIR}/package/ticktrue-config-version.cmake
  ${CMAKE_CURRENT_LIST_DIR}/float_flags.cmake ${CMAKE_CURRENT_LIST_DIR}/ticktrue_trace_test.cmake
  DESTINATION ${ticktrue_package} COMPONENT sdk)
file(RELATIVE_PATH ticktrue_pc_to_prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
ticktrue_float_flags(ticktrue_pc_float_flags ${CMAKE_CXX_COMPILER_ID})
list(JOIN ticktrue_pc_float_flags " " ticktrue_pc_float_flags)
if(ZSTD_LIBRARY)
  set(ticktrue_pc_zstd "-lzstd ")
endif()
set(ticktrue_pc_modules ticktrue ticktrue-determinism)
if(TARGET ticktrue_c_static)
  list(APPEND ticktrue_pc_modules ticktrue-static)
endif()
foreach(module ${ticktrue_pc_modules})
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${module}.pc.in ${CMAKE_BINARY_DIR}/package/${module}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/package/${module}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT sdk)
endforeach()
