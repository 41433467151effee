# ssjs_fuzz_sonar_log: the log readers with the address and the undefined-behaviour sanitizer, fed with damaged logs. clang brings libFuzzer,
# which follows what the readers do with its input; other compilers take the plain mutation driver beside the target.

file(GLOB ssjs_reader_sources CONFIGURE_DEPENDS "cpp/src/io/*.cpp")
list(FILTER ssjs_reader_sources EXCLUDE REGEX "/event_log\\.cpp$") # no reader
add_executable(ssjs_fuzz_sonar_log tests/fuzz/sonar_log_fuzz.cpp ${ssjs_reader_sources} cpp/src/base/error.cpp
               cpp/src/features/navigation_tick.cpp)
ssjs_compile_options(ssjs_fuzz_sonar_log)
target_include_directories(ssjs_fuzz_sonar_log PRIVATE cpp/include)
target_link_libraries(ssjs_fuzz_sonar_log PRIVATE Eigen3::Eigen)
set(ssjs_fuzz_sanitizers address,undefined)
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  string(APPEND ssjs_fuzz_sanitizers ",fuzzer")
else()
  target_sources(ssjs_fuzz_sonar_log PRIVATE tests/fuzz/mutation_driver.cpp)
endif()
target_compile_options(ssjs_fuzz_sonar_log PRIVATE -g1 -fsanitize=${ssjs_fuzz_sanitizers} -fno-sanitize-recover=all)
target_link_options(ssjs_fuzz_sonar_log PRIVATE -fsanitize=${ssjs_fuzz_sanitizers})
