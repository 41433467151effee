# One executable per folder of tests/cpp, ssjs_test_<folder>, from its *_test.cpp; every test is one ctest test with its folder
# as label. Tests whose full name holds "Long" carry the label "long" instead: `ctest -LE long` leaves them out.

find_package(GTest REQUIRED)
include(GoogleTest)

file(GLOB_RECURSE ssjs_test_sources RELATIVE "${PROJECT_SOURCE_DIR}/tests/cpp" CONFIGURE_DEPENDS "tests/cpp/*_test.cpp")
set(ssjs_test_folders "")
foreach(source IN LISTS ssjs_test_sources)
  string(REGEX MATCH "^[^/]+" folder "${source}")
  list(APPEND ssjs_test_folders ${folder})
  list(APPEND ssjs_test_sources_${folder} "${PROJECT_SOURCE_DIR}/tests/cpp/${source}")
endforeach()
list(REMOVE_DUPLICATES ssjs_test_folders)

# The library that a folder of tests is about; all others are about ssjs::slam.
set(ssjs_test_library_imaging imaging)
set(ssjs_test_library_cascade cascade)
set(ssjs_test_library_optical optical)
set(ssjs_test_library_survey survey)

# The filter and what lies on the way to it, with Eigen's watch over the heap: tests/cpp/allocation. A library by itself, as one program must not
# hold both builds of a source.
set(ssjs_watched_sources
    geometry/gaussian geometry/point_grid geometry/se2 geometry/se3 sensors/ackerman sensors/constant_velocity sensors/navigation_sensors
    sensors/camera_frame sensors/pinhole sensors/range_bearing sensors/side_scan features/navigation_tick association/compatibility
    association/joint_compatibility association/joint_factor association/nearest_neighbour filter/ekf filter/levelled_filter
    filter/map_state filter/symmetric_update filter/whitening mapping/base_fix mapping/frame_association mapping/levelled_builder
    mapping/levelled_builder_camera mapping/levelled_journal mapping/levelled_record mapping/sighting_association mapping/split_policy
    simulation/auv_survey simulation/route)
list(TRANSFORM ssjs_watched_sources PREPEND "${PROJECT_SOURCE_DIR}/cpp/src/")
list(TRANSFORM ssjs_watched_sources APPEND ".cpp")
add_library(ssjs_watched STATIC EXCLUDE_FROM_ALL ${ssjs_watched_sources})
ssjs_compile_options(ssjs_watched)
target_compile_definitions(ssjs_watched PUBLIC EIGEN_RUNTIME_NO_MALLOC)
target_compile_options(ssjs_watched PUBLIC -UNDEBUG)
target_link_libraries(ssjs_watched PUBLIC ssjs_base Eigen3::Eigen)
target_include_directories(ssjs_watched PUBLIC "${PROJECT_SOURCE_DIR}/cpp/include")
target_precompile_headers(ssjs_watched PRIVATE ${SSJS_PRECOMPILED_HEADERS})
set(ssjs_test_library_allocation watched)

foreach(folder IN LISTS ssjs_test_folders)
  set(test_library ${ssjs_test_library_${folder}})
  if(NOT test_library)
    set(test_library slam)
  elseif(NOT test_library IN_LIST ssjs_parts AND NOT test_library STREQUAL "watched")
    continue()
  endif()
  set(test_target ssjs_test_${folder})
  add_executable(${test_target} ${ssjs_test_sources_${folder}})
  ssjs_compile_options(${test_target})
  target_include_directories(${test_target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/cpp")
  target_link_libraries(${test_target} PRIVATE ssjs_${test_library} GTest::gtest_main)
  if(folder STREQUAL "embed")
    target_link_libraries(${test_target} PRIVATE ssjs_online) # beside ssjs::slam, which simulates
    add_executable(ssjs_survivor tests/cpp/embed/survivor.cpp) # to be killed
    ssjs_compile_options(ssjs_survivor)
    target_include_directories(ssjs_survivor PRIVATE tests/cpp)
    target_link_libraries(ssjs_survivor PRIVATE ssjs_slam ssjs_online)
    add_dependencies(${test_target} ssjs_survivor)
    target_compile_definitions(${test_target} PRIVATE SSJS_SURVIVOR="$<TARGET_FILE:ssjs_survivor>")
    target_include_directories(${test_target} PRIVATE "${PROJECT_SOURCE_DIR}/examples/ros2" "${PROJECT_SOURCE_DIR}/tests/cpp/embed/ros2_stand_in")
  endif()
  if(NOT test_library STREQUAL "slam")
    # nothing precompiled: these sources see no Eigen
  elseif(NOT DEFINED ssjs_test_pch_owner)
    set(ssjs_test_pch_owner ${test_target})
    target_precompile_headers(${test_target} PRIVATE ${SSJS_PRECOMPILED_HEADERS} <gtest/gtest.h>)
  else()
    target_precompile_headers(${test_target} REUSE_FROM ${ssjs_test_pch_owner})
  endif()
  gtest_discover_tests(${test_target} DISCOVERY_MODE PRE_TEST TEST_FILTER "-*Long*" PROPERTIES LABELS "${folder}")
  gtest_discover_tests(${test_target} DISCOVERY_MODE PRE_TEST TEST_FILTER "*Long*" PROPERTIES LABELS long)
endforeach()
