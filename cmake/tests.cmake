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

foreach(folder IN LISTS ssjs_test_folders)
  set(test_library ${ssjs_test_library_${folder}})
  if(NOT test_library)
    set(test_library slam)
  elseif(NOT test_library IN_LIST ssjs_parts)
    continue()
  endif()
  set(test_target ssjs_test_${folder})
  add_executable(${test_target} ${ssjs_test_sources_${folder}})
  ssjs_compile_options(${test_target})
  target_include_directories(${test_target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/cpp")
  target_link_libraries(${test_target} PRIVATE ssjs_${test_library} GTest::gtest_main)
  if(folder STREQUAL "embed")
    target_link_libraries(${test_target} PRIVATE ssjs_online) # beside ssjs::slam, which simulates
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
