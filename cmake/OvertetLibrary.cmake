# overtet_library(): one libovertet (static, or shared with OVERTET_SHARED) of the objects of all rooms that there
# are so far. Its target is overtet_library, here and for others overtet::overtet. Others see include/ and Eigen;
# what else it links is named so that it can be found on any machine.
function(overtet_library)
  get_property(objects GLOBAL PROPERTY OVERTET_OBJECTS)
  if(OVERTET_SHARED)
    add_library(overtet_library SHARED ${objects})
  else()
    add_library(overtet_library STATIC ${objects})
  endif()
  add_library(overtet::overtet ALIAS overtet_library)
  # 0.x: every second number is another ABI.
  set_target_properties(overtet_library PROPERTIES OUTPUT_NAME overtet EXPORT_NAME overtet LINKER_LANGUAGE CXX
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(overtet_library PUBLIC cxx_std_20)
  target_include_directories(overtet_library PUBLIC
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  # Matrices are allocated on one side and freed on the other: both must align them alike, whatever -march says.
  target_compile_definitions(overtet_library INTERFACE $<INSTALL_INTERFACE:EIGEN_MAX_ALIGN_BYTES=16>)
  target_link_libraries(overtet_library PUBLIC Eigen3::Eigen
    PRIVATE TBB::tbb Threads::Threads cadical gmp mpfr z ${CMAKE_DL_LIBS})
  add_dependencies(overtet_library overtet-tetgen)
endfunction()
