# One fuzzer a parser, ssjs_fuzz_<name>, from tests/fuzz/<name>_fuzz.cpp. With SSJS_BUILD_FUZZERS and clang these are libFuzzer targets;
# otherwise the plain mutation driver beside them feeds them. In every build with tests they replay, as ctest tests labelled "fuzz", the
# inputs of tests/data/fuzz/<name> that once went wrong.

# ssjs_fuzzer(NAME LIBRARY... [SOURCES FILE...] [UNTRACED]): UNTRACED is for fuzzers whose input no comparison of integers takes apart. libFuzzer
# is told of every comparison, and in Eigen's loops that is half of the time.
add_custom_target(ssjs_fuzzers)
function(ssjs_fuzzer name)
  cmake_parse_arguments(PARSE_ARGV 1 fuzzer "UNTRACED" "" "SOURCES")
  set(target ssjs_fuzz_${name})
  add_executable(${target} "${PROJECT_SOURCE_DIR}/tests/fuzz/${name}_fuzz.cpp" ${fuzzer_SOURCES})
  ssjs_compile_options(${target})
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/fuzz")
  target_link_libraries(${target} PRIVATE ${fuzzer_UNPARSED_ARGUMENTS})
  if(SSJS_BUILD_FUZZERS AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    target_link_options(${target} PRIVATE -fsanitize=fuzzer)
    if(fuzzer_UNTRACED)
      target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/fuzz/untraced_comparisons.cpp")
      foreach(width IN ITEMS 1 2 4 8)
        target_link_options(${target} PRIVATE LINKER:--wrap=__sanitizer_cov_trace_cmp${width} LINKER:--wrap=__sanitizer_cov_trace_const_cmp${width})
      endforeach()
    endif()
  else()
    target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/fuzz/mutation_driver.cpp")
  endif()
  add_dependencies(ssjs_fuzzers ${target})
  set(inputs "${PROJECT_SOURCE_DIR}/tests/data/fuzz/${name}")
  if(SSJS_BUILD_TESTS AND EXISTS "${inputs}")
    add_test(NAME fuzz_inputs.${name} COMMAND ${target} "${inputs}" -runs=0)
    set_tests_properties(fuzz_inputs.${name} PROPERTIES LABELS fuzz TIMEOUT 60)
  endif()
endfunction()

if(SSJS_BUILD_FUZZERS)
  target_compile_options(ssjs_base PRIVATE -O2 $<$<CXX_COMPILER_ID:Clang>:-fno-sanitize-coverage=trace-cmp>) # checksums, the search for misspelt keys
endif()
ssjs_fuzzer(sonar_log ssjs_slam)
ssjs_fuzzer(log_columns ssjs_slam)
ssjs_fuzzer(settings ssjs_slam UNTRACED) # keys are compared by memcmp, which libFuzzer hears of by another way
ssjs_fuzzer(online ssjs_slam UNTRACED SOURCES ${ssjs_online_sources}) # as part of the program: what the shared library hides is followed too
ssjs_fuzzer(checkpoint ssjs_slam UNTRACED)
if(SSJS_BUILD_IMAGING)
  ssjs_fuzzer(cascade_json ssjs_cascade)
  ssjs_fuzzer(cascade_xml ssjs_cascade)
endif()
