# overtet_room(NAME [PROGRAM] SOURCES ... [CGAL_SOURCES ...] [LINKS ...] [PRIVATE_LINKS ...])
#
# One static library for one folder of kernels/ or src/. Headers are included by their path from the
# top of the repository ("kernels/bvh/bvh.h", "src/mesh/topology.h"). LINKS are the rooms and libraries
# whose types appear in the room's headers; PRIVATE_LINKS stay inside its .cpp files. CGAL_SOURCES are the
# files that include CGAL: its interval arithmetic needs -frounding-math, which the others do without.
# PROGRAM: the room belongs to the program, not to libovertet.
function(overtet_room name)
  cmake_parse_arguments(ROOM "PROGRAM" "" "SOURCES;CGAL_SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(overtet_${name} STATIC ${ROOM_SOURCES})
  target_include_directories(overtet_${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(overtet_${name} PUBLIC overtet_public ${ROOM_LINKS} PRIVATE ${ROOM_PRIVATE_LINKS})
  if(NOT name STREQUAL core)  # every room may use kernels/core
    list(APPEND ROOM_LINKS overtet_core)
    target_link_libraries(overtet_${name} PUBLIC overtet_core)
  endif()
  if(ROOM_SOURCES)
    target_precompile_headers(overtet_${name} REUSE_FROM overtet_precompiled)
  endif()
  overtet_unity(overtet_${name})
  if(ROOM_CGAL_SOURCES)
    add_library(overtet_${name}_cgal OBJECT ${ROOM_CGAL_SOURCES})
    target_include_directories(overtet_${name}_cgal PRIVATE ${CMAKE_SOURCE_DIR})
    target_link_libraries(overtet_${name}_cgal
      PRIVATE overtet_public ${ROOM_LINKS} ${ROOM_PRIVATE_LINKS} CGAL::CGAL)
    overtet_unity(overtet_${name}_cgal)
    target_sources(overtet_${name} PRIVATE $<TARGET_OBJECTS:overtet_${name}_cgal>)
    target_link_libraries(overtet_${name} PRIVATE gmp mpfr)
    set_property(GLOBAL APPEND PROPERTY OVERTET_OBJECTS $<TARGET_OBJECTS:overtet_${name}_cgal>)
  endif()
  if(NOT ROOM_PROGRAM)  # what overtet_library() puts together
    set_property(GLOBAL APPEND PROPERTY OVERTET_OBJECTS $<TARGET_OBJECTS:overtet_${name}>)
  endif()
endfunction()

# overtet_unity(TARGET): with OVERTET_UNITY, files of one target are compiled some at a time, in two thirds of the CPU time:
# templates are instantiated once for all of them. So what two files of a target keep to themselves needs two
# names. Debug builds compile each file by itself.
function(overtet_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${OVERTET_UNITY} UNITY_BUILD_BATCH_SIZE 8)
endfunction()

# overtet_test(NAME [SLOW] SOURCES ... LINKS ...): one GoogleTest program for one folder of tests/. Its tests have
# the label fast, or slow where the folder takes more than ten seconds.
function(overtet_test name)
  cmake_parse_arguments(T "SLOW" "" "SOURCES;LINKS" ${ARGN})
  set(label fast)
  if(T_SLOW)
    set(label slow)
  endif()
  set(timeout 300)
  if(OVERTET_SANITIZE)  # ten times as slow
    set(timeout 3000)
  endif()
  add_executable(test_${name} ${T_SOURCES})
  target_include_directories(test_${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(test_${name} PRIVATE ${T_LINKS} overtet_test_support GTest::gtest_main
    gmpxx gmp)  # for messages with exact numbers
  # Tests need not be fast, but quick to build. -O1 gives the same numbers as -O3.
  target_compile_options(test_${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(CMAKE_POSITION_INDEPENDENT_CODE)  # CMake would say -fPIE, and precompiled headers of -fPIC be of no use
    set_target_properties(test_${name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(test_${name} PRIVATE -fPIC)
  endif()
  target_precompile_headers(test_${name} REUSE_FROM overtet_test_support)
  overtet_unity(test_${name})
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT ${timeout} LABELS ${label})
endfunction()
