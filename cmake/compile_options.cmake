# ssjs_compile_options(TARGET): what every target of this project is compiled with. Nothing of it is exported.
function(ssjs_compile_options target)
  target_compile_features(${target} PRIVATE cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  # The same numbers on machines with and without fused multiply-add.
  target_compile_options(${target} PRIVATE -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
  if(SSJS_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(SSJS_SANITIZE)
    list(JOIN SSJS_SANITIZE "," sanitizers)
    # Without the null check: Eigen takes the address of the first coefficient of empty matrices, and never reads it.
    target_compile_options(${target} PRIVATE -fsanitize=${sanitizers} -fno-sanitize=null -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC $<BUILD_INTERFACE:-fsanitize=${sanitizers}>)
  endif()
  if(SSJS_BUILD_FUZZERS AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link) # libFuzzer follows where its input leads
  endif()
endfunction()

# ssjs_count_lines(LIBRARY): with SSJS_COVERAGE it notes which of its lines are run. Only the libraries do: tests compile to the objects of any other
# build of theirs, which ccache has.
function(ssjs_count_lines library)
  if(SSJS_COVERAGE)
    target_compile_options(${library} PRIVATE --coverage -O1 -g1)
    target_link_options(${library} PUBLIC $<BUILD_INTERFACE:--coverage>)
  endif()
endfunction()

# Parsing Eigen takes half of the time of a typical source file. gcc refuses a precompiled header made with other flags
# (position-independent library, executable), so that each kind of target has its own.
set(SSJS_PRECOMPILED_HEADERS <Eigen/Core> <Eigen/Cholesky> <Eigen/LU> <string> <vector>)
