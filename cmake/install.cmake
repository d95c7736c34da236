# `cmake --install`: the tool, the C interface as a library, and what finds them (CMake package, pkg-config).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(ticktrue_package ${CMAKE_INSTALL_LIBDIR}/cmake/ticktrue)

# The flags of docs/determinism.md for whoever wants them; the library itself asks nothing of its users.
add_library(ticktrue_flags INTERFACE)
set_target_properties(ticktrue_flags PROPERTIES EXPORT_NAME determinism)
target_compile_options(ticktrue_flags INTERFACE -ffp-contract=off -fno-math-errno
  $<$<C_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)

target_include_directories(ticktrue_c INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set_target_properties(ticktrue PROPERTIES EXPORT_NAME tool)
if(TARGET ticktrue_c_static)
  target_include_directories(ticktrue_c_static INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(TARGETS ticktrue_c_static EXPORT ticktrue-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
endif()

install(TARGETS ticktrue_c ticktrue_flags EXPORT ticktrue-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
install(TARGETS ticktrue EXPORT ticktrue-targets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sdk)
install(FILES ${PROJECT_SOURCE_DIR}/include/ticktrue.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT sdk)
install(EXPORT ticktrue-targets NAMESPACE ticktrue:: DESTINATION ${ticktrue_package} COMPONENT sdk)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/ticktrue-config.cmake.in
  ${CMAKE_BINARY_DIR}/package/ticktrue-config.cmake INSTALL_DESTINATION ${ticktrue_package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/ticktrue-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/ticktrue-config.cmake ${CMAKE_BINARY_DIR}/package/ticktrue-config-version.cmake
  ${CMAKE_CURRENT_LIST_DIR}/ticktrue_trace_test.cmake DESTINATION ${ticktrue_package} COMPONENT sdk)
file(RELATIVE_PATH ticktrue_pc_to_prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(${CMAKE_CURRENT_LIST_DIR}/ticktrue.pc.in ${CMAKE_BINARY_DIR}/package/ticktrue.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/package/ticktrue.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT sdk)
