# install(): headers, libovertet, the package for find_package(overtet CONFIG), overtet.pc, the program, and its
# helper in libexec. All of it can be moved to another prefix as a whole; a program that links the static library
# then says where the helper is (RunContext::tetgen_helper).
include(CMakePackageConfigHelpers)

set(OVERTET_HELPER_DIR ${CMAKE_INSTALL_LIBEXECDIR}/overtet)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/overtet)

if(OVERTET_SHARED)  # the program finds the library wherever the whole has been moved
  file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(overtet PROPERTIES INSTALL_RPATH "$ORIGIN/${from_bin}")
endif()
install(TARGETS overtet RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(TARGETS overtet-tetgen RUNTIME DESTINATION ${OVERTET_HELPER_DIR} COMPONENT program)
if(TARGET overtet-picture)
  install(TARGETS overtet-picture RUNTIME DESTINATION ${OVERTET_HELPER_DIR} COMPONENT pictures)
endif()
install(DIRECTORY ${CMAKE_BINARY_DIR}/manuals/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program
  FILES_MATCHING PATTERN "*.1.gz")
install(FILES ${CMAKE_BINARY_DIR}/manuals/overtet COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions)
install(FILES ${CMAKE_BINARY_DIR}/manuals/_overtet COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/zsh/vendor-completions)
install(FILES ${CMAKE_BINARY_DIR}/manuals/overtet.fish COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/fish/vendor_completions.d)
install(TARGETS overtet_library EXPORT overtet
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT program NAMELINK_COMPONENT development)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/include/overtet DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT development FILES_MATCHING PATTERN "*.h")

install(EXPORT overtet NAMESPACE overtet:: FILE overtet-targets.cmake DESTINATION ${package_dir}
  COMPONENT development)
configure_package_config_file(cmake/overtet-config.cmake.in ${CMAKE_BINARY_DIR}/package/overtet-config.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS OVERTET_HELPER_DIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/overtet-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/overtet-config.cmake
              ${CMAKE_BINARY_DIR}/package/overtet-config-version.cmake
  DESTINATION ${package_dir} COMPONENT development)

file(RELATIVE_PATH OVERTET_PREFIX_FROM_PC ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
set(OVERTET_PC_LIBS "-L\${libdir} -lovertet")
set(OVERTET_PC_STATIC_LIBS "-lcadical -ltbb -lmpfr -lgmp -lz -ldl -pthread")
if(NOT OVERTET_SHARED)  # then everybody links what it needs
  string(APPEND OVERTET_PC_LIBS " ${OVERTET_PC_STATIC_LIBS}")
endif()
configure_file(cmake/overtet.pc.in ${CMAKE_BINARY_DIR}/package/overtet.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/package/overtet.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
  COMPONENT development)
if(NOT OVERTET_SHARED)
  include(OvertetPackage)
endif()
