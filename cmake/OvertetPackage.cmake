# cpack -G DEB: packages for Debian, `overtet` (the program and its helper), `libovertet-dev` (headers and the static
# library, which needs the helper), with OVERTET_PYTHON `python3-overtet` (which needs the helper, too), and where VTK is
# `overtet-pictures` (what draws, as VTK brings a lot with it). Of a static build: nobody has asked for a package of the shared library yet.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME overtet)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "tetrahedral meshes of surfaces that pass through themselves")
set(CPACK_PACKAGE_CONTACT "Overtet maintainers <maintainers@overtet.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL program development)
if(OVERTET_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TARGET overtet-picture)
  list(APPEND CPACK_COMPONENTS_ALL pictures)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME overtet)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# Loaded when it is needed first (kernels/sparse), so that nothing links it.
set(cholmod_version "")
foreach(header cholmod_core.h cholmod.h)  # of SuiteSparse before 6, and since
  if(cholmod_version STREQUAL "" AND EXISTS ${OVERTET_CHOLMOD_INCLUDE}/suitesparse/${header})
    file(STRINGS ${OVERTET_CHOLMOD_INCLUDE}/suitesparse/${header} cholmod_version REGEX "define CHOLMOD_MAIN_VERSION +[0-9]")
    string(REGEX REPLACE ".*VERSION +" "" cholmod_version "${cholmod_version}")
  endif()
endforeach()
if(cholmod_version STREQUAL "")
  message(WARNING "CHOLMOD's headers do not say its version: packages made here would depend on no package that there is.")
endif()
# Loaded when they are needed, so that nothing else tells.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libcholmod${cholmod_version}, libmuparser2v5")
# It becomes the BLAS of CHOLMOD, several times as fast as the reference one; one thread, as kernels/sparse asks.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libopenblas0-serial")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "overtet-pictures")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION
  "Overtet fills a closed triangle surface with tetrahedra that overlap where
the surface does. Every input triangle stays a boundary triangle; where no such
mesh exists, it says why in a way that anyone can check.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libovertet-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "overtet (= ${PROJECT_VERSION}), libeigen3-dev, libtbb-dev, libcadical-dev, \
libgmp-dev, libmpfr-dev")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION
  "Overtet fills a closed triangle surface with tetrahedra that overlap where
the surface does. This package has what programs need that call it: the headers,
a static library, and its descriptions for CMake and pkg-config.")

if(OVERTET_PYTHON)
  get_property(Python3_VERSION_MINOR GLOBAL PROPERTY OVERTET_PYTHON_MINOR)  # python/ has found it
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-overtet)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "overtet (= ${PROJECT_VERSION}), \
python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy, libcholmod${cholmod_version}")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-meshio, python3-vtk9, python3-matplotlib")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    ${CMAKE_SOURCE_DIR}/cmake/debian/python/postinst ${CMAKE_SOURCE_DIR}/cmake/debian/python/prerm)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION
    "Overtet fills a closed triangle surface with tetrahedra that overlap where
the surface does. This package has the module overtet for Python: numpy arrays
in, numpy arrays out.")
endif()

if(TARGET overtet-picture)
  set(CPACK_DEBIAN_PICTURES_PACKAGE_NAME overtet-pictures)
  set(CPACK_DEBIAN_PICTURES_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PICTURES_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PICTURES_PACKAGE_DEPENDS "overtet (= ${PROJECT_VERSION}), libegl-mesa0, libgl1-mesa-dri")
  set(CPACK_DEBIAN_PICTURES_DESCRIPTION
    "Overtet fills a closed triangle surface with tetrahedra that overlap where
the surface does. This package lets overtet view draw pictures (PNG), with VTK,
without a display or a graphics card.")
endif()

# What Debian's policy wants beside every package.
find_program(GZIP gzip)
file(READ ${CMAKE_SOURCE_DIR}/LICENSE license)
set(cadical_licence /usr/share/doc/libcadical-dev/copyright)  # it is linked into both packages
if(EXISTS ${cadical_licence})
  file(READ ${cadical_licence} cadical_copyright)
else()
  message(WARNING "${cadical_licence} is missing: packages made here lack CaDiCaL's licence, so do not pass them on.")
endif()
configure_file(cmake/debian/copyright.in package/copyright @ONLY)
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} component)
  set(PACKAGE ${CPACK_DEBIAN_${component}_PACKAGE_NAME})
  string(TOLOWER ${component} lower)
  set(doc_dir ${CMAKE_INSTALL_DATAROOTDIR}/doc/${PACKAGE})
  install(FILES ${CMAKE_BINARY_DIR}/package/copyright DESTINATION ${doc_dir} COMPONENT ${lower})
  if(GZIP)
    configure_file(cmake/debian/changelog.in package/${PACKAGE}/changelog @ONLY)
    execute_process(COMMAND ${GZIP} -9nkf changelog WORKING_DIRECTORY ${CMAKE_BINARY_DIR}/package/${PACKAGE})
    install(FILES ${CMAKE_BINARY_DIR}/package/${PACKAGE}/changelog.gz DESTINATION ${doc_dir} COMPONENT ${lower})
  endif()
endforeach()
include(CPack)
