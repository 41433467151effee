# CHOLMOD of SuiteSparse, which Debian ships without a CMake package.
#
# Defines the target CHOLMOD::CHOLMOD and CHOLMOD_FOUND, CHOLMOD_VERSION. Expects the shared library, which knows the
# SuiteSparse and LAPACK libraries it needs. Set CHOLMOD_ROOT to look in one place first.

find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)

if(CHOLMOD_INCLUDE_DIR)
  file(STRINGS "${CHOLMOD_INCLUDE_DIR}/cholmod.h" cholmod_version_lines REGEX "#define[ \t]+CHOLMOD_(MAIN|SUB|SUBSUB)_VERSION[ \t]+[0-9]+")
  if(NOT cholmod_version_lines) # before SuiteSparse 7 the numbers stand in cholmod_core.h
    file(STRINGS "${CHOLMOD_INCLUDE_DIR}/cholmod_core.h" cholmod_version_lines REGEX "#define[ \t]+CHOLMOD_(MAIN|SUB|SUBSUB)_VERSION[ \t]+[0-9]+")
  endif()
  string(REGEX REPLACE "[^;]*[ \t]([0-9]+)[^;0-9]*" "\\1" cholmod_version_numbers "${cholmod_version_lines}")
  list(JOIN cholmod_version_numbers "." CHOLMOD_VERSION)
  unset(cholmod_version_lines)
  unset(cholmod_version_numbers)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  CHOLMOD
  REQUIRED_VARS CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR
  VERSION_VAR CHOLMOD_VERSION
  REASON_FAILURE_MESSAGE "install SuiteSparse (Debian: libsuitesparse-dev) or set CHOLMOD_ROOT")
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY)

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(CHOLMOD::CHOLMOD PROPERTIES IMPORTED_LOCATION "${CHOLMOD_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}")
endif()
